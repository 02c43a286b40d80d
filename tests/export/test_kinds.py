"""`oed export`: every form has what the robot's own file has, and runs where it is meant to."""

import dataclasses
import json
import os
import subprocess
import sys

import casadi
import mujoco
import numpy as np
import pytest
import yaml

from oed.commands.main import run
from oed.dynamics.motion import Motion
from oed.export.model_file import write_model
from oed.export.registry import EXPORTERS, OWN
from oed.robot import load_robot
from oed.robot.xml_tree import parse_xml
from tests.docs.code_blocks import blocks
from tests.dynamics.effects.arms import panda, scara
from tests.export.every_effect import model_with
from tests.paths import REPO

WITH_OED = {**os.environ, "PYTHONPATH": str(REPO)}
URDF_JOINT = 2  # of the Panda, whose limits are looked at


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """The Panda in every form."""
    folder = tmp_path_factory.mktemp("export")
    names = ("stribeck", "load_dependent_friction", "time_delay")
    model, _ = model_with(*names, robot=panda(), duration=0.3)
    write_model(model, folder / "in" / "model.json")
    status = run(["export", str(folder / "in"), "--to", *OWN, "--out", str(folder / "out")])
    assert status == 0
    return model, folder / "out"


def xml(text):
    return parse_xml(text.encode(), "a test").root


def test_urdf_is_the_robots_own_but_for_what_was_found(exported):
    model, out = exported
    own = xml(model.robot.description.text)
    new = xml((out / "robot.urdf").read_text(encoding="utf-8"))
    assert new.get("name") == own.get("name")
    for tag in ("link", "joint", "visual", "collision", "mesh"):
        assert len(list(new.iter(tag))) == len(list(own.iter(tag)))
    for root in (own, new):
        limit = root.find("joint[@name='panda_joint3']/limit")
        assert limit is not None
        assert float(limit.attrib["effort"]) == model.robot.limits.torque[URDF_JOINT, 1]


@pytest.mark.parametrize(("name", "tags"), [("robot.sdf", ("visual", "collision"))])
def test_sdf_has_shapes_limits_and_the_robots_name(exported, name, tags):
    model, out = exported
    own = xml(model.robot.description.text)
    new = xml((out / name).read_text(encoding="utf-8"))
    arm = new.find("model")
    assert arm is not None
    assert arm.get("name") == own.get("name")
    for tag in tags:
        assert len(list(new.iter(tag))) == len(list(own.iter(tag)))
    again = load_robot(out / name, joints=model.robot.joint_names)
    for kind in ("position", "velocity", "torque"):
        assert np.allclose(getattr(again.limits, kind), getattr(model.robot.limits, kind))
    for uri in new.iter("uri"):
        assert (out / uri.text).is_file()


@pytest.mark.parametrize("name", ["robot.xml", "robot_mujoco.xml"])
def test_mjcf_has_shapes_limits_and_the_robots_name(exported, name):
    model, out = exported
    own = xml(model.robot.description.text)
    mjmodel = mujoco.MjModel.from_xml_path(str(out / name))
    looks = [i for i in range(mjmodel.ngeom) if "_look_" in mjmodel.geom(i).name]
    assert len(looks) == len(list(own.iter("visual")))
    assert mjmodel.ngeom - len(looks) == len(list(own.iter("collision")))
    assert mjmodel.names.split(b"\0")[0].decode() == own.get("name")
    joint = mjmodel.joint("panda_joint3")
    assert joint.range == pytest.approx(model.robot.limits.position[URDF_JOINT])
    control = mjmodel.actuator("panda_joint3").ctrlrange
    assert control == pytest.approx(model.robot.limits.torque[URDF_JOINT])
    assert (joint.frictionloss[0] > 0) == (name == "robot.xml")
    data = mujoco.MjData(mjmodel)
    mujoco.mj_forward(mjmodel, data)
    where = {mjmodel.body(i).name: data.xpos[i] for i in range(mjmodel.nbody)}
    # The base's drawing lies where the base is, and the last link's on the last link.
    first = data.geom_xpos[looks[0]]
    last = data.geom_xpos[next(i for i in looks if "link7" in mjmodel.geom(i).name)]
    assert np.linalg.norm(first) < 0.2
    assert np.linalg.norm(last - where["panda_link7"]) < 0.2


def test_casadi_functions_load_alone(exported):
    model, out = exported
    begin = casadi.Function.load(str(out / "arm_begin.casadi"))
    torque = casadi.Function.load(str(out / "arm.casadi"))
    state = np.full(model.robot.n, 0.3)
    whole = dataclasses.replace(model.torque_model, measurement=())
    expected = whole.torque(model.parameters, Motion(np.zeros(1), *[state[None]] * 3))[0]
    found, _ = torque(state, state, state, begin(state, state, state))
    assert np.array(found).ravel() == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("script", ["predict.py", "simulate_mujoco.py", "simulate_drake.py"])
def test_scripts_run_from_anywhere(exported, tmp_path, script):
    _, out = exported
    text = (out / script).read_text(encoding="utf-8")
    short = text.replace("range(1000)", "range(3)").replace("AdvanceTo(1.0)", "AdvanceTo(0.003)")
    (out / f"short_{script}").write_text(short, encoding="utf-8")
    command = [sys.executable, str(out / f"short_{script}")]
    told = subprocess.run(
        command, capture_output=True, text=True, check=True, cwd=tmp_path, env=WITH_OED
    )
    assert len(told.stdout.split()) > 7


def test_ros2_parameters_are_of_types_that_ros2_has(exported):
    model, out = exported
    read = yaml.safe_load((out / "model_parameters.yaml").read_text(encoding="utf-8"))
    dynamics = read["/**"]["ros__parameters"]["dynamics"]
    assert dynamics["joint_names"] == list(model.robot.joint_names)
    own = dynamics["joints"]["panda_joint3"]
    assert own["inertial"] == model.parameters[20:30].tolist()
    _check_types(dynamics)


def _check_types(value):
    for each in value.values():
        if isinstance(each, dict):
            _check_types(each)
        elif isinstance(each, list):
            assert len({type(item) for item in each}) == 1
        else:
            assert isinstance(each, bool | int | float | str)


def test_what_a_form_lacks_is_in_the_record_with_the_reason(exported):
    _, out = exported
    record = json.loads((out / "export.json").read_text(encoding="utf-8"))
    left = {
        name: {item["name"] for item in told["left_out"]}
        for name, told in record["exports"].items()
    }
    assert left["c"] == set()
    assert left["mujoco"] == left["drake"] == {"time_delay"}
    assert left["urdf"] == {"stribeck", "load_dependent_friction", "time_delay"}


def test_base_parameters_are_no_bodies(tmp_path, capsys):
    model, _ = model_with("stribeck", robot=scara(), duration=0.2)
    parameters = model.parameters.copy()
    parameters[[0, 10]] = 0.0
    bodiless = type(model)(**{**vars(model), "parameters": parameters})
    path = write_model(bodiless, tmp_path / "model.json")
    assert run(["export", str(path), "--to", "urdf", "--out", str(tmp_path / "out")]) == 3
    told = capsys.readouterr().err
    assert "no body has the inertia" in told
    assert "oed feasible DATA --model FILE" in told
    assert not list((tmp_path / "out").glob("*.urdf"))
    assert run(["export", str(path), "--to", "c", "--out", str(tmp_path / "out")]) == 0


def test_an_unknown_form_is_refused_before_anything_is_read(tmp_path, capsys):
    arguments = ["export", str(tmp_path / "none.json"), "--to", "urdff", "--out", "x"]
    assert run(arguments) == 2
    assert "no form 'urdff' to export to; known are numpy" in capsys.readouterr().err


def test_the_form_of_the_how_to_is_exported_to(tmp_path):
    exec(blocks(REPO / "docs/how-to/export.md", "python")[-1], {})  # noqa: S102  # the page's own code
    model, _ = model_with(robot=scara(), duration=0.1)
    path = write_model(model, tmp_path / "model.json")
    assert "masses" in EXPORTERS.names()
    assert run(["export", str(path), "--to", "masses", "--out", str(tmp_path / "out")]) == 0
    found = np.loadtxt(tmp_path / "out" / "masses.txt")
    assert found == pytest.approx(model.robot.parameters[::10])
