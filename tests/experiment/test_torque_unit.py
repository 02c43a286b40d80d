"""What is called torque is N m or amperes, and every number says which."""

import dataclasses
import json

import numpy as np
import pytest

from oed.dynamics.identifiability import base_parameters
from oed.errors import NoUsableResult
from oed.experiment.dataset import DataSet
from oed.experiment.drive import TorqueKind
from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Recording
from oed.experiment.write_dataset import write_dataset
from oed.export.calibrated_robot import CalibratedRobot
from oed.export.model import Model, Origin
from oed.export.model_file import load_model, write_model
from tests.estimation.load.carrying_arm import MODEL, ROBOT, sweep, torque
from tests.running import oed

GAINS = np.array([14.0, 12.5, 11.0, 9.0, 8.0, 8.5])  # [N m/A]


def write(folder, divided, *, units="", torque_kind: TorqueKind = "current"):
    """A data set of torques over constants, whatever they are called."""
    rng = np.random.default_rng(3)
    motion = sweep(rng, 12.0)
    tau = torque(motion, is_loaded=False) / divided
    recording = Recording("log", "estimation", motion.t, motion.q, tau)
    dataset = DataSet("arm", "made", "CC0", ROBOT, torque_kind, recordings=(recording,))
    write_dataset(dataset, folder)
    manifest = folder / "dataset.toml"
    lines = manifest.read_text(encoding="utf-8").split("[units]")
    head = lines[0].replace('torque = "current"', f'torque = "current"\n{units}')
    manifest.write_text(head, encoding="utf-8")
    return read_dataset(folder)


@pytest.mark.parametrize(
    ("divided", "units", "unit", "note"),
    [
        (GAINS, "", "A", "taken for amperes"),
        (np.ones(6), "", "N m", "taken for N m"),
        (GAINS, 'units = {tau = "N m"}', "N m", None),
        (np.ones(6), 'units = {tau = "mA"}', "A", "A per unit"),
    ],
)
def test_what_is_stated_decides_and_else_the_file_s_inertials(tmp_path, divided, units, unit, note):
    found = write(tmp_path / "arm", divided, units=units)
    assert set(found.torque_units) == {unit}
    told = [n for n in found.notes if "current_to_torque" in n]
    assert not told if note is None else note in told[0]


def test_parameters_of_currents_are_in_amperes_per_unit():
    base = base_parameters(MODEL.with_robot(ROBOT.with_amperes()))
    units = dict(zip(base.names, base.units, strict=True))
    assert units["Fc_2"] == "A"
    assert units["Fv_2"] == "A s/rad"
    assert units["mx_2"] == "A s^2/m"
    assert units["Izz_1"] == "A s^2"
    assert not any("kg" in unit or "N" in unit for unit in units.values())


def test_units_of_a_slide_and_of_rotors():
    turning, sliding = (
        ROBOT.with_amperes().joints[0],
        dataclasses.replace(ROBOT.with_amperes().joints[0], kind="prismatic"),
    )
    assert [turning.unit(u) for u in ("N m", "N m s/rad", "kg m^2")] == [
        "A",
        "A s/rad",
        "A s^2/rad",
    ]
    assert [sliding.unit(u) for u in ("N m", "N m s/rad", "kg m^2")] == ["A", "A s/m", "A s^2/m"]


def test_writing_and_reading_keep_the_unit(tmp_path):
    dataset = write(tmp_path / "arm", GAINS)
    write_dataset(dataset, tmp_path / "again")
    assert set(read_dataset(tmp_path / "again").torque_units) == {"A"}


def test_a_model_file_keeps_the_unit_and_makes_no_robot_file(tmp_path):
    robot = ROBOT.with_amperes()
    torque_model = MODEL.with_robot(robot)
    count = len(torque_model.parameters)
    origin = Origin("a test", "arm", "none", "today", None, None, {})
    model = Model(
        torque_model, np.ones(count), None, np.ones(count, dtype=bool),
        is_feasible=False, validity=None, origin=origin,
    )  # fmt: skip
    again = load_model(write_model(model, tmp_path / "model.json"))
    assert again.robot.in_amperes
    units = {
        p["unit"]
        for e in json.loads((tmp_path / "model.json").read_text())["effects"]
        for p in e["parameters"]
    }
    assert "A" in units
    assert "kg" not in units
    with pytest.raises(NoUsableResult, match=r"no URDF, SDF or MJCF.*oed gains"):
        CalibratedRobot.of(again.torque_model, again.parameters)


def test_no_command_makes_a_robot_file_of_currents(tmp_path, capsys):
    write(tmp_path / "arm", GAINS)
    for command in ("feasible", "calibrate"):
        assert oed(command, tmp_path / "arm", "--quiet", "--out", tmp_path / command) == 3
        said = capsys.readouterr().err
        assert "at the joint per A of the motor, gear included" in said
        assert said.count("\n") == 1
        assert not [
            p for p in (tmp_path / command).glob("**/*") if p.suffix in (".urdf", ".xml", ".sdf")
        ]
