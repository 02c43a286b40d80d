"""Does a weighed load lie within its 95 % intervals, and what decides how wide these are?

    python -m studies.payload [--workers N] [--smoke] [--out results/payload]

Loads of 0.1 to 5 kg on a simulated UR5, a Panda and a four-axis SCARA; torques by Drake, with Stribeck
friction that no model declares, friction that grows with the load and changes from day to day. A run that
was interrupted goes on where it stopped.
"""

from __future__ import annotations

import time
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from oed.commands.configurations import ModelName
from oed.commands.options import parse
from oed.dynamics.models import build_model
from oed.estimation.load.friction_curve import with_friction_curve
from oed.estimation.load.known_arm import KnownArm
from oed.estimation.load.loaded_model import LoadedModel
from oed.estimation.load.payload import Payload, estimate_payload
from oed.estimation.load.quantities import central_inertia
from oed.estimation.stacking import process_all
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.preparation.settings import choose_settings
from oed.process_end import RESUMES, leave
from studies.carrying_arms import ARMS
from studies.case_runner import CaseRunner, Outcome, RowFile, leave_page, work_through
from studies.payload_arms import TrueArm, draw_load, random_motion_of, record
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
    """

    seconds: float
    bare: float
    speed: float
    loads: int
    designed: bool = False
    drift: float = 0.0
    model: ModelName = "rotor"


CELLS = {
    "usual": Cell(10.0, 30.0, 1.0, 70),
    "20 s": Cell(20.0, 30.0, 1.0, 10),
    "3 s": Cell(3.0, 30.0, 1.0, 10),
    "3 s, designed": Cell(3.0, 30.0, 1.0, 10, designed=True),
    "6 s, designed": Cell(6.0, 30.0, 1.0, 10, designed=True),
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
    """All loads; the cell with the most first."""
    return list(_cases(config))


def _cases(config: Config) -> Iterator[Case]:
    for cell in config.cells:
        for number in range(min(CELLS[cell].loads, config.most)):
            for arm in config.arms:
                yield Case(arm, cell, number, CELLS[cell])


def work(case: Case) -> Outcome:
    """Weigh one load, with and without friction that grows with it in the model."""
    start = time.process_time()
    rng = np.random.default_rng([zlib.crc32("/".join(case.key).encode()), case.number])
    arm = ARMS[case.arm]
    true, body, coloured = TrueArm.draw(arm, rng), draw_load(rng), bool(case.number % 2)
    bare = (
        None
        if not case.how.bare
        else record(
            arm,
            true,
            random_motion_of(arm, case.how.bare, rng),
            rng,
            coloured=coloured,
            name="bare",
        )
    )
    motion = (
        designed_motion(arm.key, case.how.seconds)
        if case.how.designed
        else random_motion_of(arm, case.how.seconds, rng, speed=case.how.speed)
    )
    holding = true.another_day(rng, drift=case.how.drift).holding(arm.frame, body)
    loaded = record(arm, holding, motion, rng, coloured=coloured, name="loaded")
    found, without = (
        weigh(arm.key, bare, loaded, model=case.how.model, has_load_friction=x)
        for x in (True, False)
    )
    return {
        "status": "ok",
        **judged(found, body),
        "mass_error_without": without.mass / body[0] - 1,
        "held_without": _held(without, body)[1],
        "seconds": time.process_time() - start,
    }


def weigh(
    arm: str,
    bare: DataSet | None,
    loaded: DataSet,
    *,
    model: ModelName = "rotor",
    has_load_friction: bool = True,
) -> Payload:
    """The load, from what was logged."""
    kind = ARMS[arm]
    recordings = processed(loaded)
    before = () if bare is None else processed(bare)
    alone = LoadedModel.bare(
        with_friction_curve(build_model(model, kind.robot, sign_width=SIGN_WIDTH)),
        kind.frame,
        has_load_friction=has_load_friction,
    ).turning_as(before or recordings)
    known = (
        KnownArm.from_recordings(alone, before) if before else KnownArm.from_file(alone, recordings)
    )
    return estimate_payload(known, recordings)


def processed(dataset: DataSet) -> tuple[ProcessedRecording, ...]:
    """As the commands process it."""
    return process_all(dataset, choose_settings(dataset.recordings))["estimation"]


def judged(found: Payload, body: np.ndarray) -> dict[str, str | float]:
    """Which intervals hold the truth, how far off the estimate is, and how wide they are.

    Args:
        found: The estimate.
        body: The truth about the frame.
    """
    truth = _truth(body)
    error = np.array([q.value for q in found.quantities]) - truth
    half = [
        np.nan if q.interval is None else (q.interval[1] - q.interval[0]) / 2
        for q in found.quantities
    ]
    return {
        "mass": body[0],
        "held": _held(found, body),
        "mass_error": error[0] / body[0],
        "mass_half": half[0] / body[0],
        "centre_error": float(np.linalg.norm(error[1:4])),
        "centre_half": _largest(half[1:4]),
        "inertia_half": _largest(half[4:]),
        "margin": found.margin,
    }


def _largest(half: Sequence[float]) -> float:
    return float(np.max(half)) if np.isfinite(half).all() else float("nan")


def _held(found: Payload, body: np.ndarray) -> str:
    """One letter a quantity: 1 held, 0 not held, - no interval claimed."""
    letters = []
    for quantity, true in zip(found.quantities, _truth(body), strict=True):
        if quantity.interval is None:
            letters.append("-")
        else:
            low, high = quantity.interval
            letters.append("1" if low <= true <= high else "0")
    # A first letter that no table takes for a number.
    return "h" + "".join(letters)


def _truth(body: np.ndarray) -> np.ndarray:
    inertia = central_inertia(body)[np.triu_indices(3)]
    return np.concatenate([body[:1], body[1:4] / body[0], inertia])


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
