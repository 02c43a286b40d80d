"""Does a weighed load lie within its 95 % intervals, and what decides how wide these are?

    python -m studies.payload [--workers N] [--smoke] [--out results/payload]

Loads of 0.1 to 5 kg on a simulated UR5, a Panda and a four-axis SCARA; torques by Drake, with Stribeck
friction that no model declares, friction that grows with the load and changes from day to day. All cells
weigh the same loads on the same arms, so that they compare. A run that was interrupted goes on where it
stopped.
"""

from __future__ import annotations

import time
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from oed.commands.configurations import ModelName
from oed.commands.options import parse
from oed.dynamics.friction_curve import with_friction_curve
from oed.dynamics.models import build_model
from oed.estimation.load.known_arm import KnownArm
from oed.estimation.load.loaded_model import LoadedModel
from oed.estimation.load.payload import estimate_payload
from oed.estimation.stacking import process_all
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.preparation.settings import choose_settings
from oed.process_end import RESUMES, leave
from studies.carrying_arms import ARMS
from studies.case_runner import CaseRunner, Outcome, RowFile, leave_page, work_through
from studies.payload_arms import TrueArm, draw_load, random_motion_of, record
from studies.payload_judged import held, judged
from studies.payload_motion import designed_motion
from studies.payload_summary import page
from studies.study_options import CaseOptions

RUNS = "runs.csv"
KEY_COLUMNS = ("arm", "cell", "number")
VALUE_COLUMNS = (
    "status",
    "mass",
    "held",
    "mass_error",
    "mass_half",
    "centre_error",
    "centre_half",
    "inertia_half",
    "margin",
    "mass_error_without",
    "held_without",
    "seconds",
)
SIGN_WIDTH = 0.02  # [rad/s], as of the commands
DRIFT = 0.05  # of Coulomb friction


@dataclass(frozen=True)
class Cell:
    """How loads are weighed.

    Attributes:
        seconds: Length of the motion with the load [s].
        bare: Length of the motion without; 0 for none, with the robot's file in its place [s].
        speed: Share of the speed at which the load is moved.
        loads: How many are weighed on each arm.
        designed: Whether the motion with the load is that of `oed design --payload`.
        drift: Of the torque's offsets between the two days, as a share of Coulomb friction.
        model: Of the arm, as --torque-model.
        without: Whether a model without friction that grows with the load weighs it too.
    """

    seconds: float
    bare: float
    speed: float
    loads: int
    designed: bool = False
    drift: float = 0.0
    model: ModelName = "rotor"
    without: bool = False


CELLS = {
    "usual": Cell(10.0, 30.0, 1.0, 70, without=True),
    "20 s": Cell(20.0, 30.0, 1.0, 20),
    "3 s": Cell(3.0, 30.0, 1.0, 20),
    "3 s, designed": Cell(3.0, 30.0, 1.0, 20, designed=True),
    "6 s, designed": Cell(6.0, 30.0, 1.0, 20, designed=True),
    "slow": Cell(10.0, 30.0, 0.1, 10),
    "bare 10 s": Cell(10.0, 10.0, 1.0, 10),
    "bare 60 s": Cell(10.0, 60.0, 1.0, 10),
    "robot file": Cell(10.0, 0.0, 1.0, 10),
    "offsets drift": Cell(10.0, 30.0, 1.0, 10, drift=DRIFT),
    "offsets drift, modelled": Cell(10.0, 30.0, 1.0, 10, drift=DRIFT, model="offset"),
}


@dataclass(frozen=True)
class Case:
    """One load on one arm.

    Attributes:
        arm: Key of the arm.
        cell: Key of the cell.
        number: Of the load.
        how: The cell.
    """

    arm: str
    cell: str
    number: int
    how: Cell

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        return (self.arm, self.cell, str(self.number))


@dataclass(frozen=True)
class Config:
    """What is simulated.

    Attributes:
        arms: Keys.
        cells: Keys.
        most: Loads a cell and arm, at most.
    """

    arms: tuple[str, ...] = ("ur5", "panda", "scara")
    cells: tuple[str, ...] = tuple(CELLS)
    most: int = 1000


SMOKE = Config(arms=("scara",), cells=("3 s",), most=1)


def cases_of(config: Config) -> list[Case]:
    """All loads; what is weighed on one arm side by side, as its bare recording is processed once."""
    return list(_cases(config))


def _cases(config: Config) -> Iterator[Case]:
    for arm in config.arms:
        for number in range(config.most):
            cells = [cell for cell in config.cells if number < CELLS[cell].loads]
            if not cells:
                break
            yield from (Case(arm, cell, number, CELLS[cell]) for cell in cells)


def work(case: Case) -> Outcome:
    """Weigh one load; where it is asked for, without friction that grows with it in the model too."""
    start = time.process_time()
    how, rng = case.how, _source(*case.key)
    arm = ARMS[case.arm]
    true, body = _drawn(case.arm, case.number)
    motion = (
        designed_motion(arm.key, how.seconds)
        if how.designed
        else random_motion_of(arm, how.seconds, rng, speed=how.speed)
    )
    day = _source(case.arm, "another day", str(case.number))
    holding = true.another_day(day, drift=how.drift).holding(arm.frame, body)
    coloured = _is_coloured(case.number)
    loaded = processed(record(arm, holding, motion, rng, coloured=coloured, name="loaded"))
    found = estimate_payload(_known(case, loaded, has_load_friction=True), loaded)
    row = {"status": "ok", **judged(found, body)}
    if how.without:
        without = estimate_payload(_known(case, loaded, has_load_friction=False), loaded)
        row["mass_error_without"] = without.mass / body[0] - 1
        row["held_without"] = held(without, body)[1]
    return {**row, "seconds": time.process_time() - start}


def _source(*key: str) -> np.random.Generator:
    return np.random.default_rng(zlib.crc32("/".join(key).encode()))


def _is_coloured(number: int) -> bool:
    """Whether the torque's noise is, on both days."""
    return bool(number % 2)


def _drawn(arm: str, number: int) -> tuple[TrueArm, np.ndarray]:
    """The arm and the load of a number, whatever the cell."""
    rng = _source(arm, str(number))
    return TrueArm.draw(ARMS[arm], rng), draw_load(rng)


def _known(
    case: Case, loaded: tuple[ProcessedRecording, ...], *, has_load_friction: bool
) -> KnownArm:
    """What is known of the arm before its load is weighed."""
    if case.how.bare:
        return _from_recordings(
            case.arm, case.number, case.how.bare, case.how.model, has_load_friction
        )
    return KnownArm.from_file(_alone(case.arm, loaded, case.how.model, has_load_friction), loaded)


@lru_cache(maxsize=6)  # of one arm and number, in all lengths and models
def _from_recordings(
    arm: str,
    number: int,
    seconds: float,
    model: ModelName,
    has_load_friction: bool,  # a part of the key
) -> KnownArm:
    rng = _source(arm, "bare", str(seconds), str(number))
    motion = random_motion_of(ARMS[arm], seconds, rng)
    true, _ = _drawn(arm, number)
    coloured = _is_coloured(number)
    bare = processed(record(ARMS[arm], true, motion, rng, coloured=coloured, name="bare"))
    return KnownArm.from_recordings(_alone(arm, bare, model, has_load_friction), bare)


def _alone(
    arm: str,
    recordings: tuple[ProcessedRecording, ...],
    model: ModelName,
    has_load_friction: bool,
) -> LoadedModel:
    """The model of an arm that holds nothing, as the commands build it."""
    kind = ARMS[arm]
    return LoadedModel.bare(
        with_friction_curve(build_model(model, kind.robot, sign_width=SIGN_WIDTH)),
        kind.frame,
        has_load_friction=has_load_friction,
    ).turning_as(recordings)


def processed(dataset: DataSet) -> tuple[ProcessedRecording, ...]:
    """As the commands process it."""
    return process_all(dataset, choose_settings(dataset.recordings))["estimation"]


@dataclass(frozen=True)
class Options(CaseOptions):
    """Does a weighed load lie within its 95 % intervals?"""

    study: ClassVar[str] = "payload"
    names: ClassVar[tuple[str, ...]] = ("summary.md", "provenance.json")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 1 if all failed, else 0."""
    options = parse(Options, prog="python -m studies.payload", arguments=arguments)
    config = SMOKE if options.smoke else Config()
    rows = RowFile(options.results / RUNS, KEY_COLUMNS, VALUE_COLUMNS)
    runner = CaseRunner(work, rows, "payload")
    return work_through(
        runner,
        cases_of(config),
        options,
        config,
        lambda out: leave_page(page(rows.rows()), config, None, out),
    )


if __name__ == "__main__":
    leave(main, "studies.payload", RESUMES)
