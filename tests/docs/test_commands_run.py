"""The commands of readme and documentation run, one after another, on an arm and logs with the names they have there."""

from __future__ import annotations

import dataclasses
import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from oed.commands.main import COMMANDS, configuration_of
from oed.experiment.dataset import DataSet
from oed.experiment.write_dataset import write_dataset
from oed.robot import Robot, load_robot
from oed.robot.inertia import transform_parameters
from tests.docs.code_blocks import oed_lines, oed_lines_in_sentences
from tests.experiment.importing.laboratory_logs import (
    TORQUE_CONSTANT,
    bag_mcap,
    simulate,
    write_urdf,
)
from tests.running import oed

LINES = list(oed_lines())
IMPORT = next(words for words in LINES if words[0] == "import")
# The demo has a test of its own, and so have a refinement and what a shell completes by.
ELSEWHERE = {"demo", "--refine"}
OTHERS = [words for words in LINES if not ELSEWHERE & {*words} and words[0] in COMMANDS]
# A diagnosis takes the time that it is given, and as long as it has candidates to try.
FEW = ["--smoke", "--budget", "0", "--candidates", "stribeck"]
LESS = dict.fromkeys(("diagnose", "calibrate"), FEW)
# What the pages' examples say of the load: its mass [kg] and centre in the last link's frame [m].
MASS, CENTRE = 2.805, np.array([0.0, 0.0, 0.06])
LIGHTER = 1.0  # [kg]
SHAPE = '<collision><origin xyz="0 0 -0.15"/><geometry><box size="0.06 0.06 0.36"/></geometry></collision>'
TOOL = """<link name="tool0"/><joint name="flange" type="fixed"><parent link="wrist_link"/>
<child link="tool0"/></joint></robot>"""


def holding(robot: Robot, mass: float) -> Robot:
    """The arm with a small ball in its hand."""
    inertia = 0.004 * mass / MASS * np.array([1.0, 0.0, 0.0, 1.0, 0.0, 1.0])
    ball = transform_parameters(np.concatenate([[mass, 0, 0, 0], inertia]), np.eye(3), CENTRE)
    parameters = robot.parameters.copy()
    parameters[-10:] += ball
    return robot.with_parameters(parameters)


def log(robot: Robot, folder: Path, mass: float, units: np.ndarray) -> None:
    """A data set of the arm with a load, its torques over so many units."""
    truth = simulate(holding(robot, mass))
    plain = DataSet.from_arrays(robot, t=truth.t, q=truth.q, tau=truth.tau / units)
    if (units != 1.0).any():
        plain = dataclasses.replace(plain, robot=robot.with_amperes(), torque="current")
    write_dataset(plain, folder)


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with arm.urdf and logs of it, with a load and without; in N m, and below in A."""
    folder = tmp_path_factory.mktemp("laboratory")
    text = write_urdf(folder / "arm.urdf").read_text()
    text = text.replace("</inertial></link>", f"</inertial>{SHAPE}</link>")
    (folder / "arm.urdf").write_text(text.replace("</robot>", TOOL))
    robot = load_robot(folder / "arm.urdf")
    bag_mcap(simulate(robot), folder).rename(folder / "log.mcap")
    before = Path.cwd()
    os.chdir(folder)
    try:
        assert oed(*IMPORT) == 0
    finally:
        os.chdir(before)
    torques, currents = np.ones(3), np.array(TORQUE_CONSTANT)
    for name, mass in (("bare", 0.0), ("loaded", MASS), ("held", MASS)):
        log(robot, folder / name, mass, torques)
    for name, mass in (
        ("bare", 0.0),
        ("amps", 0.0),
        ("loaded", MASS),
        ("held", MASS),
        ("a", LIGHTER),
        ("b", MASS),
    ):
        log(robot, folder / "currents" / name, mass, currents)
    logs = folder / "logs"
    logs.mkdir()
    for name in ("log.mcap", "arm.urdf"):
        shutil.copy(folder / name, logs)
    for name in ("bare", "loaded"):
        shutil.copy(min((folder / name).glob("*.csv")), logs / f"{name}.csv")
    return folder


# What the logs of a page lie in, where that is not the laboratory itself.
PLACES = {"gains": "currents", "import": "logs"}


@pytest.mark.parametrize("words", OTHERS, ids=" ".join)
def test_runs(words: tuple[str, ...], laboratory: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(laboratory / PLACES.get(words[0], ""))
    config = configuration_of(words)
    less = LESS.get(words[0], ["--smoke"] if hasattr(config, "smoke") else [])
    assert oed(*words, *less) == 0
    if "--out" in words:
        assert any(path.is_file() for path in Path(words[words.index("--out") + 1]).iterdir())


def test_what_a_sentence_shows_is_run_as_well() -> None:
    assert oed_lines_in_sentences() - set(LINES) == set()


def test_every_command_is_on_a_page() -> None:
    assert {words[0] for words in LINES} >= {*COMMANDS} - {"cross-check"}
