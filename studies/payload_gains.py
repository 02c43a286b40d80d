"""Are gains that are 15 % off found from a known load, and which of them can be?

    python -m studies.payload_gains [--workers N] [--smoke] [--out results/payload_gains]

A simulated UR10 whose currents are its torques over gains that nobody knows to better than 15 %; a load of
2.805 kg, its centre of mass known or not. Beside the estimate of `oed gains` stand two that the
literature has, each on the same rows: total least squares of k i = H beta + L phi (Gautier and Briot
2014), and the same with simulated torques as instruments.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import binom

from oed.commands.options import parse
from oed.dynamics.friction_curve import with_friction_curve
from oed.dynamics.models import build_model
from oed.estimation.load.current_equations import CurrentEquations, KnownLoad
from oed.estimation.load.gains import estimate_gains
from oed.estimation.load.loaded_model import LoadedModel
from oed.estimation.load.quantities import LEVEL
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.processed import ProcessedRecording
from oed.process_end import RESUMES, leave
from oed.report.table import Row, markdown_table
from oed.robot.inertia import transform_parameters
from studies.carrying_arms import ARMS
from studies.case_runner import CaseRunner, Outcome, RowFile, leave_page, work_through
from studies.gain_references import references
from studies.payload import SIGN_WIDTH, processed
from studies.payload_arms import TrueArm, draw_load, random_motion_of, record
from studies.study_options import CaseOptions

RUNS = "runs.csv"
KEY_COLUMNS = ("knows", "number")
VALUE_COLUMNS = ("status", "joint", "held", "error", "half", "error_tls", "error_iv", "seconds")
GAINS = np.array([14.0, 14.5, 13.0, 9.5, 9.0, 9.0])  # [N m/A], of the size that makers publish
SPREAD = 0.15  # by which nobody knows them
MASS = 2.805  # [kg]
SECONDS = 30.0  # of both motions
JOINTS = ARMS["ur10"].robot.joint_names
FINE = 0.01  # half width of an interval by which a gain counts as known to 1 %


@dataclass(frozen=True)
class Case:
    """One arm with one load.

    Attributes:
        knows: "mass", or "mass and centre" of the load.
        number: Of the arm.
    """

    knows: str
    number: int

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        return (self.knows, str(self.number))


@dataclass(frozen=True)
class Config:
    """What is simulated.

    Attributes:
        knows: What is known of the load.
        arms: How many.
    """

    knows: tuple[str, ...] = ("mass", "mass and centre")
    arms: int = 80


SMOKE = Config(knows=("mass",), arms=1)


def cases_of(config: Config) -> list[Case]:
    """All arms."""
    return list(_cases(config))


def _cases(config: Config) -> Iterator[Case]:
    for number in range(config.arms):
        for knows in config.knows:
            yield Case(knows, number)


@dataclass(frozen=True)
class Logged:
    """One arm, logged without and with its load.

    Attributes:
        gains: (n,) true ones [N m/A].
        body: The true load about the frame.
        model: Of the bare arm.
        bare: Processed currents.
        loaded: Likewise.
    """

    gains: Float[ndarray, " joints"]
    body: Float[ndarray, "10"]
    model: LoadedModel
    bare: tuple[ProcessedRecording, ...]
    loaded: tuple[ProcessedRecording, ...]


@lru_cache(maxsize=1)  # the same arm whatever is known of its load
def logged(number: int) -> Logged:
    """The arm of a number."""
    rng = np.random.default_rng(number)
    arm, coloured = ARMS["ur10"], bool(number % 2)
    true = TrueArm.draw(arm, rng)
    gains = GAINS * (1 + SPREAD * rng.uniform(-1, 1, len(GAINS)))
    body = draw_load(rng)
    body = body * MASS / body[0]
    holding = true.another_day(rng).holding(arm.frame, body)
    logs = [
        _in_amperes(
            record(arm, state, random_motion_of(arm, SECONDS, rng), rng, coloured=coloured, name=n),
            gains,
        )
        for state, n in ((true, "bare"), (holding, "loaded"))
    ]
    bare, loaded = (processed(log) for log in logs)
    model = LoadedModel.bare(
        with_friction_curve(build_model("rotor", logs[0].robot, sign_width=SIGN_WIDTH)), arm.frame
    ).turning_as(bare)
    return Logged(gains, body, model, bare, loaded)


def work(case: Case) -> Outcome:
    """Find the gains of one arm, three ways; numbers of its joints stand side by side."""
    start = time.process_time()
    arm, log = ARMS["ur10"], logged(case.number)
    gains, body = log.gains, log.body
    centre = body[1:4] / body[0] if case.knows != "mass" else None
    known = [KnownLoad(MASS, centre)]
    equations = CurrentEquations.of(log.model, log.bare, [log.loaded], known)
    found = estimate_gains(equations)
    values = np.array([np.nan if g.value is None else g.value for g in found.gains])
    half = [
        np.nan if g.interval is None else (g.interval[1] - g.interval[0]) / 2 / k
        for g, k in zip(found.gains, gains, strict=True)
    ]
    about_joint = transform_parameters(body, arm.frame.R_JF, arm.frame.p_JF)
    tls, iv = references(equations, about_joint)
    return {
        "status": "ok",
        "joint": " ".join(JOINTS),
        "held": "h"
        + "".join(
            "-" if g.interval is None else str(int(g.interval[0] <= k <= g.interval[1]))
            for g, k in zip(found.gains, gains, strict=True)
        ),
        "error": _listed(values / gains - 1),
        "half": _listed(half),
        "error_tls": _listed(tls / gains - 1),
        "error_iv": _listed(iv / gains - 1),
        "seconds": time.process_time() - start,
    }


def page(rows: Sequence[dict[str, str]]) -> str:
    """The rows as a page."""
    good = [row for row in rows if row["status"] == "ok"]
    tables = "".join(
        f"\n## Known of the load: {knows}\n\n" + markdown_table(_joints(own), digits=3)
        for knows in dict.fromkeys(row["knows"] for row in good)
        if (own := [row for row in good if row["knows"] == knows])
    )
    return (
        "# Gains, found from a known load\n\n"
        f"{len(good)} estimates on simulated UR10 arms, {len(rows) - len(good)} more failed. Gains are drawn "
        f"up to {SPREAD:.0%} off; {SECONDS:g} s without and with a load of {MASS} kg; undeclared friction "
        "and noise as in `studies.payload`. `told`: share of arms for which the gain is told (its "
        "interval is within 10 %); `held`: share of intervals that hold the truth, of which chance allows "
        f"{_allowed(good)} at 95 % for one that is right; errors are rms; `to 1 %`: share of arms whose "
        "interval says that the gain is known to 1 %, and the rms error there. Total "
        "least squares (TLS) and instrumental variables (IV) are given the whole load, all ten "
        "parameters, and no friction that grows with it.\n"
        + tables
        + "\n## Why total least squares err\n\n"
        "TLS take the noise of all columns for even. Here the columns of the motion have none and the "
        "currents have that of six different joints, with what the model lacks on top; the last singular "
        "vector is then the direction that the motion excites least, and the gains follow it.\n"
    )


def _joints(rows: Sequence[dict[str, str]]) -> list[Row]:
    error, half, tls, iv = (
        np.array([[float(x) for x in row[column].split()] for row in rows])
        for column in ("error", "half", "error_tls", "error_iv")
    )
    held = np.array([list(row["held"][1:]) for row in rows])
    found: list[Row] = []
    for j, name in enumerate(JOINTS):
        told = held[:, j] != "-"
        found.append(
            {
                "joint": name,
                "told": float(np.mean(told)),
                "held": float(np.mean(held[told, j] == "1")) if told.any() else None,
                "error": _rms(error[told, j]) if told.any() else None,
                "half width": float(np.median(half[told, j])) if told.any() else None,
                "to 1 %": float(np.mean(fine := told & (half[:, j] <= FINE))),
                "error there": _rms(error[fine, j]) if fine.any() else None,
                "error TLS": _rms(tls[:, j]),
                "error IV": _rms(iv[:, j]),
                "TLS negative": float(np.mean(tls[:, j] < -1)),
            }
        )
    return found


def _allowed(rows: Sequence[dict[str, str]]) -> str:
    """Between which shares of a table's arms hold the truth, where 95 % of all do."""
    arms = max(len({row["number"] for row in rows}), 1)
    low, high = binom.interval(LEVEL, arms, LEVEL)
    return f"{low / arms:.3g} to {high / arms:.3g}"


def _rms(values: Float[ndarray, " k"]) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _in_amperes(dataset: DataSet, gains: Float[ndarray, " joints"]) -> DataSet:
    """As the reader gives a log of currents."""
    (log,) = dataset.recordings
    currents = replace(log, tau=log.tau / gains)
    robot = dataset.robot.with_amperes()
    return replace(dataset, robot=robot, torque="current", recordings=(currents,))


def _listed(values: Sequence[float] | Float[ndarray, " joints"]) -> str:
    return " ".join(f"{float(x):.5g}" for x in values)


@dataclass(frozen=True)
class Options(CaseOptions):
    """Are gains that are 15 % off found from a known load?"""

    study: ClassVar[str] = "payload_gains"
    names: ClassVar[tuple[str, ...]] = ("summary.md", "provenance.json")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 1 if all failed, else 0."""
    options = parse(Options, prog="python -m studies.payload_gains", arguments=arguments)
    config = SMOKE if options.smoke else Config()
    rows = RowFile(options.results / RUNS, KEY_COLUMNS, VALUE_COLUMNS)
    runner = CaseRunner(work, rows, "payload_gains")
    return work_through(
        runner,
        cases_of(config),
        options,
        config,
        lambda out: leave_page(page(rows.rows()), config, None, out),
    )


if __name__ == "__main__":
    leave(main, "studies.payload_gains", RESUMES)
