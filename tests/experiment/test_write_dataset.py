"""What is written is read back unchanged, and a failed write leaves nothing."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from oed.experiment import write_dataset as module
from oed.experiment.dataset import DataSet
from oed.experiment.drive import DRIVE_KEYS, Drive
from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Recording
from oed.experiment.write_dataset import write_dataset
from oed.robot import imi_scara, load_robot
from tests.experiment.tiny_dataset import urdf_text
from tests.paths import SHARED_DATA, needs_shared_data

ARRAYS = ("t", "q", "tau", "dq", "ddq", "repetition", "temperature")


def made_up(seed: int = 0, drive: Drive | None = None) -> DataSet:
    """A data set with every field there is, of numbers with all their digits.

    Positions repeat and velocities are theirs: the reader refuses what contradicts itself.
    """
    rng = np.random.default_rng(seed)

    def recording(name: str, role) -> Recording:
        def draw(columns: int) -> np.ndarray:
            return rng.normal(size=(60, columns)) * 10.0 ** rng.integers(-12, 1, (60, columns))

        t = np.arange(60) / 60 + rng.uniform(0, 1e-3, 60)
        turns = 6 * np.pi * t[:, None] + rng.uniform(0, 2 * np.pi, 2)
        return Recording(
            name=name,
            role=role,
            t=t,
            q=np.sin(turns),
            tau=draw(2),
            dq=6 * np.pi * np.cos(turns),
            ddq=draw(2),
            repetition=np.arange(60) // 20,
            temperature=draw(3),
            period=1 / 3,
        )

    robot = imi_scara()
    return DataSet(
        name='quoted "name"',
        source="a\nb",
        licence="CC0",
        robot=robot.with_gravity(np.array([0.1, -9.8, 0.3])).with_limits(
            robot.limits.with_(
                acceleration=np.array([[-4.0, 5.0], [-np.inf, np.inf]]),
                torque=np.array([[-70.0, 70.0], [-70 / 3, 70 / 3]]),
            )
        ),
        torque="commanded",
        drive=drive or Drive(),
        recordings=(recording("runs/a", "estimation"), recording("b.1", "test")),
    )


def assert_same(one: DataSet, other: DataSet) -> None:
    for key in ("name", "source", "licence", "torque"):
        assert getattr(one, key) == getattr(other, key)
    for kind in dataclasses.fields(one.robot.limits):
        assert np.array_equal(
            getattr(one.robot.limits, kind.name), getattr(other.robot.limits, kind.name)
        )
    assert np.array_equal(one.robot.gravity, other.robot.gravity)
    assert np.array_equal(one.robot.parameters, other.robot.parameters)
    assert one.robot.joint_names == other.robot.joint_names
    for key in DRIVE_KEYS:
        assert np.array_equal(getattr(one.drive, key), getattr(other.drive, key))
    for a, b in zip(one.recordings, other.recordings, strict=True):
        assert (a.name, a.role, a.period) == (b.name, b.role, b.period)
        for field in ARRAYS:
            x, y = getattr(a, field), getattr(b, field)
            assert (x is None) == (y is None)
            assert x is None or (x.dtype == y.dtype and np.array_equal(x, y)), field


@pytest.mark.parametrize("file_format", ["csv", "parquet"])
def test_round_trip_is_exact(tmp_path, file_format):
    dataset = made_up()
    write_dataset(dataset, tmp_path / "set", file_format=file_format)
    assert_same(dataset, read_dataset(tmp_path / "set"))


def test_torques_from_currents_go_back_to_the_last_bit(tmp_path):
    rng = np.random.default_rng(1)
    factor = np.array([11.1, -0.37])
    dataset = made_up(drive=Drive(current_to_torque=factor, gear_ratio=np.array([101.0, 50.0])))
    currents = rng.normal(size=(60, 2)) * 10.0 ** rng.integers(-9, 3, (60, 2))
    recordings = tuple(dataclasses.replace(r, tau=currents * factor) for r in dataset.recordings)
    dataset = dataclasses.replace(dataset, recordings=recordings)
    write_dataset(dataset, tmp_path / "set")
    assert_same(dataset, read_dataset(tmp_path / "set"))


def test_the_robots_file_is_copied(tmp_path):
    (tmp_path / "arm.urdf").write_text(urdf_text(2))
    dataset = dataclasses.replace(made_up(), robot=load_robot(tmp_path / "arm.urdf"))
    write_dataset(dataset, tmp_path / "set")
    assert (tmp_path / "set" / "robot.urdf").read_text() == urdf_text(2)
    assert_same(dataset, read_dataset(tmp_path / "set"))


@needs_shared_data
@pytest.mark.parametrize("name", ["dfki_a0", "franka_panda"])
def test_measured_sets_survive(tmp_path, name):
    dataset = read_dataset(SHARED_DATA / name)
    write_dataset(dataset, tmp_path / "set")
    assert_same(dataset, read_dataset(tmp_path / "set"))


def test_nothing_is_overwritten(tmp_path):
    write_dataset(made_up(0), tmp_path / "set")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(ValueError, match="not an empty folder"):
        write_dataset(made_up(1), tmp_path / "set")
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_a_write_that_fails_half_way_leaves_nothing(tmp_path, monkeypatch):
    written: list[Path] = []

    def fails_at_the_second(path, values):
        if written:
            raise OSError("disk full")
        written.append(path)
        path.write_text(str(values))

    monkeypatch.setattr(module, "write_columns", fails_at_the_second)
    with pytest.raises(OSError, match="disk full"):
        write_dataset(made_up(), tmp_path / "set")
    assert written
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["../a", "/a", ""])
def test_refuses_a_name_that_leaves_the_folder(tmp_path, name):
    dataset = made_up()
    recordings = (dataclasses.replace(dataset.recordings[0], name=name),)
    with pytest.raises(ValueError, match="no file name"):
        write_dataset(dataclasses.replace(dataset, recordings=recordings), tmp_path / "set")
    assert list(tmp_path.iterdir()) == []


def test_refuses_to_lose_inertial_parameters(tmp_path):
    dataset = made_up()
    robot = dataset.robot.with_parameters(2 * dataset.robot.parameters)
    with pytest.raises(ValueError, match="would be lost"):
        write_dataset(dataclasses.replace(dataset, robot=robot), tmp_path / "set")
