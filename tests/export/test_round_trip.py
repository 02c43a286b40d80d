"""Every written file, loaded by programs that did not write it, computes the same torques."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.models import build_model
from oed.dynamics.motion import random_motion
from oed.export.calibrated_robot import CalibratedRobot
from oed.export.mjcf import write_mjcf
from oed.export.round_trip import (
    ExportMismatch,
    require_round_trip,
    torque_by_drake,
    torque_by_pinocchio,
)
from oed.export.sdf import write_sdf
from oed.export.simulation_plant import build_simulation_plant
from oed.export.urdf import write_urdf
from oed.robot import arm_joints, load_robot
from oed.robot.robot_file import load_plant
from tests.estimation.feasible.cases import random_body, random_tree, true_parameters
from tests.paths import example_robot

WRITERS = {"robot.urdf": write_urdf, "robot.sdf": write_sdf, "robot.xml": write_mjcf}
PANDA = "panda_description/urdf/panda.urdf"
ARM = [f"panda_joint{i}" for i in range(1, 8)]


def identified(robot, seed=1):
    """A robot with bodies unlike those of its file."""
    rng = np.random.default_rng(seed)
    model = build_model("rotor", robot)
    parameters = true_parameters(model, rng)
    parameters[: 10 * robot.n] = np.concatenate([random_body(rng) for _ in range(robot.n)])
    return CalibratedRobot.of(model, parameters), random_motion(robot, 8, rng), model, parameters


def agrees(found, expected):
    return np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("kind", ["panda", "tree", "imi_scara"])
def test_drake_computes_the_same_torques(tmp_path, name, kind):
    robot = {
        "panda": lambda: load_robot(example_robot(PANDA), joints=ARM),
        "tree": lambda: random_tree(6, np.random.default_rng(3)),
        "imi_scara": lambda: load_robot("builtin:imi_scara"),
    }[kind]()
    calibrated, motion, _, _ = identified(robot)
    path = WRITERS[name](calibrated, tmp_path / name)
    assert require_round_trip(calibrated, path, motion) < 1e-9


@pytest.mark.parametrize(
    ("file", "held"),
    [
        (PANDA, {"panda_joint4": -1.2, "panda_joint2": 0.4}),
        ("tiago_description/robots/tiago.urdf", {"torso_lift_joint": 0.2, "arm_3_joint": 0.9}),
    ],
)
def test_joints_that_were_held_are_fixed_where_they_were(tmp_path, file, held):
    path = example_robot(file)
    joints = [name for name in arm_joints(path) if name not in held]
    robot = load_robot(path, joints=joints, locked=held)
    calibrated, motion, _, _ = identified(robot)
    written = write_urdf(calibrated, tmp_path / "robot.urdf")
    assert require_round_trip(calibrated, written, motion) < 1e-9
    assert set(arm_joints(written)) == set(joints)


@pytest.mark.parametrize("name", ["robot.urdf", "robot.xml"])
def test_pinocchio_computes_the_same_torques(tmp_path, name):
    calibrated, motion, _, _ = identified(load_robot(example_robot(PANDA), joints=ARM))
    path = WRITERS[name](calibrated, tmp_path / name)
    assert agrees(torque_by_pinocchio(path, calibrated, motion), calibrated.smooth_torque(motion))


def test_the_loaded_file_has_the_same_parameters(tmp_path):
    calibrated, _, _, _ = identified(load_robot(example_robot(PANDA), joints=ARM))
    for name, write in WRITERS.items():
        again = load_robot(write(calibrated, tmp_path / name), joints=ARM)
        assert np.allclose(again.parameters, calibrated.robot.parameters, rtol=1e-9, atol=1e-12)


def test_smooth_torque_is_the_models_without_coulomb_friction():
    calibrated, motion, model, parameters = identified(load_robot("builtin:imi_scara"))
    smooth = parameters.copy()
    smooth[[k for k, p in enumerate(model.parameters) if p.name.startswith("Fc_")]] = 0.0
    assert agrees(calibrated.smooth_torque(motion), model.torque(smooth, motion))


def test_urdf_keeps_what_else_is_in_the_file(tmp_path):
    source = example_robot(PANDA)
    calibrated, _, _, _ = identified(load_robot(source, joints=ARM))
    text = write_urdf(calibrated, tmp_path / "robot.urdf").read_text(encoding="utf-8")
    assert text.count("<visual") == source.read_text(encoding="utf-8").count("<visual")
    assert f'friction="{float(calibrated.coulomb[2])!r}"' in text


def test_friction_arrives_in_the_readers(tmp_path):
    calibrated, _, _, _ = identified(load_robot(example_robot(PANDA), joints=ARM))
    plant = load_plant(write_urdf(calibrated, tmp_path / "robot.urdf"))
    dampings = [plant.GetJointByName(name).default_damping() for name in ARM]
    assert np.allclose(dampings, calibrated.viscous, rtol=1e-15)


def test_a_file_with_other_torques_is_not_handed_on(tmp_path):
    calibrated, motion, _, _ = identified(load_robot("builtin:imi_scara"))
    path = write_urdf(calibrated, tmp_path / "robot.urdf")
    heavier = calibrated.robot.parameters.copy()
    heavier[19] *= 1 + 1e-6
    other = dataclasses.replace(calibrated, robot=calibrated.robot.with_parameters(heavier))
    with pytest.raises(ExportMismatch, match="differ") as caught:
        require_round_trip(other, path, motion)
    assert caught.value.disagreement > 1e-9


def test_refuses_a_body_without_mass(tmp_path):
    calibrated, _, _, _ = identified(load_robot("builtin:imi_scara"))
    massless = calibrated.robot.with_parameters(np.zeros(20))
    with pytest.raises(ValueError, match="positive"):
        write_sdf(dataclasses.replace(calibrated, robot=massless), tmp_path / "robot.sdf")


def test_parameters_that_no_file_holds_are_named():
    robot = load_robot("builtin:imi_scara")
    model = build_model("offset", robot)
    calibrated = CalibratedRobot.of(model, np.ones(len(model.parameters)))
    assert calibrated.left_out == ("offset_1", "offset_2")


def test_the_drake_plant_has_rotors_and_damping():
    calibrated, motion, _, _ = identified(random_tree(5, np.random.default_rng(4)))
    plant = build_simulation_plant(calibrated)
    found = torque_by_drake(plant, calibrated, motion)
    assert agrees(found, calibrated.smooth_torque(motion))
