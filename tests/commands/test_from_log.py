"""A log in place of a data set: from a bag to a report in one command."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest

from oed.commands.configurations import Identify
from oed.commands.from_log import imported
from oed.experiment.read_dataset import read_dataset
from oed.report.json_file import read_json
from oed.robot import load_robot
from tests.experiment.importing.laboratory_logs import bag_mcap, simulate, write_urdf
from tests.paths import SHARED_LOGS, example_robot, needs_shared_logs
from tests.running import oed


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("laboratory")
    arm = write_urdf(folder / "arm.urdf")
    bag_mcap(simulate(load_robot(arm), rows=1200), folder).rename(folder / "log.mcap")
    return folder


def listing(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_the_data_set_is_that_of_oed_import_and_stays(laboratory: Path, tmp_path: Path) -> None:
    arm, out = str(laboratory / "arm.urdf"), tmp_path / "out"
    options = ["--robot", arm, "--out", tmp_path / "set", "--quiet"]
    assert oed("import", laboratory / "log.mcap", *options) == 0
    config = Identify(data=laboratory / "log.mcap", out=out, robot=arm)
    imported(config, out)
    made = imported(config, out)  # it replaces what the first left
    assert (made.data, made.robot) == (out / "data", None)
    one, other = (read_dataset(folder) for folder in (made.data, tmp_path / "set"))
    assert one.name == "log"
    for a, b in zip(one.recordings, other.recordings, strict=True):
        assert (a.name, a.role) == (b.name, b.role)
        np.testing.assert_array_equal(a.tau, b.tau)
    manifest = made.data / "dataset.toml"
    manifest.write_text(manifest.read_text() + "# mine\n")
    with pytest.raises(ValueError, match="was changed since it was imported"):
        imported(config, out)
    assert manifest.read_text().endswith("# mine\n")
    assert imported(made, out) is made


def test_a_check_without_a_folder_prints_and_leaves_nothing(
    laboratory: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(laboratory)
    before = listing(laboratory)
    assert oed("check", "log.mcap", "--robot", "arm.urdf") == 0
    told = capsys.readouterr().out
    assert "importing log.mcap" in told
    assert tempfile.gettempdir() not in told  # where nobody would find anything
    assert "green  units and signs" in told
    assert "--out" in told.splitlines()[-1]
    assert listing(laboratory) == before


@pytest.mark.parametrize("command", ["check", "identify", "diagnose", "calibrate"])
def test_what_is_no_log_or_has_no_robot_is_refused_in_one_line(
    command: str, laboratory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, arm, out = laboratory / "log.mcap", laboratory / "arm.urdf", tmp_path / "out"
    for given, reason in (
        ([log], "--robot names the robot"),
        ([tmp_path / "none.mcap", "--robot", arm], "no such log"),
        ([arm, "--robot", arm], "logs of kind '.urdf' are not known"),
    ):
        assert oed(command, *given, "--out", out) == 2
        told = capsys.readouterr().err
        assert reason in told
        assert told.count("\n") == 1
        assert not out.exists()


def test_a_data_set_names_its_robot_itself(
    laboratory: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "set"
    folder.mkdir()
    (folder / "dataset.toml").touch()
    arm = ["--robot", laboratory / "arm.urdf"]
    assert oed("identify", folder, *arm, "--out", tmp_path / "out") == 2
    assert "names its robot" in capsys.readouterr().err


@needs_shared_logs
@pytest.mark.parametrize(
    ("name", "urdf", "error"),
    [
        ("ur10", "ur_description/urdf/ur10_robot.urdf", 0.055),
        ("panda", "panda_description/urdf/panda.urdf", 0.0205),
    ],
)
def test_a_recorded_bag_becomes_a_report(
    name: str, urdf: str, error: float, tmp_path: Path
) -> None:
    """Of the test part of each: what import and identify have given since these bags are known."""
    bag = SHARED_LOGS / f"{name}_exciting_trajectory.db3"
    out = tmp_path / "out"
    assert oed("identify", bag, "--robot", example_robot(urdf), "--out", out, "--quiet") == 0
    assert (out / "report.html").is_file()
    told = read_json(out / "estimate.json")
    assert told["data"] == f"{name}_exciting_trajectory"
    assert told["overall_relative_rms"]["test"] == pytest.approx(error, rel=0.1)
