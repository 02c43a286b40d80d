"""Is the predicted chance of naming the wrong one of two rivals right, and does one motion tell?

    python -m studies.discrimination [--out results/discrimination] [--seeds N] [--workers N]
                                     [--smoke]

Simulated arms of the bench hide one effect of a confusable pair. The noise is drawn anew many
times, and how often the other one is named is held against the diagnosis's prediction. Then the
diagnosis designs one motion, the arm runs it, and the fit decides.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from scipy.stats import norm

from oed.commands.options import Count, parse
from oed.diagnosis.rivals.confusion import confusion
from oed.diagnosis.rivals.discrimination import error_rate, separation
from oed.diagnosis.terms.scores import Score
from oed.process_end import RESUMES, leave
from oed.report.provenance import Provenance
from studies.case_runner import CaseRunner, Outcome, RowFile, all_failed, is_finished
from studies.discrimination_summary import write_summary
from studies.rival_experiment import Decision, Duel, Table, design, lay, tune
from studies.study_options import CaseOptions

# Two forms of the bench that look alike, and the joint at which they act.
PAIRS = (
    ("constant", "one_sided_viscous", 0),
    ("stribeck", "power_of_speed", 0),
    ("late_torque", "lagging_torque", 0),
    ("dahl", "stribeck", 1),
    ("spring", "ripple", 0),
    ("rotor", "gain", 1),
    ("load_friction", "gain", 0),
    ("position_friction", "ripple", 1),
    ("elastic", "late_torque", 0),
    ("rising_current", "gain", 0),
)
ROBOTS = ("scara", "vertical")
WANTED = (0.03, 0.1, 0.2, 0.3)  # error rates on the motion at hand, one pair after another
KEY = ("robot", "hidden", "rival", "noise", "seed", "runs", "designed_runs", "candidates")
VALUES = (
    "status",
    "size",
    "gain",
    "separation",
    "formula",
    "predicted_fit",
    "predicted_name",
    "wrong_fit",
    "wrong_name",
    "designed_separation",
    "designed_formula",
    "designed_predicted",
    "designed_resolved",
    "designed_wrong_fit",
    "designed_wrong_name",
    "designed_decided",
    "designed_misled",
    "at_hand_decided",
    "first_decided",
    "seconds",
)


@dataclass(frozen=True)
class Config:
    """What is simulated.

    Attributes:
        pairs: Of `PAIRS`, by index.
        robots: Keys of the bench's arms.
        seeds: Of every pair on every arm; each swaps what is hidden.
        runs: Draws of the noise on the motion at hand.
        read: Of these, on which the prediction is drawn.
        designed_runs: Executions of the designed motion.
        candidates: Motions that the design compares.
    """

    pairs: tuple[int, ...] = tuple(range(len(PAIRS)))
    robots: tuple[str, ...] = ROBOTS
    seeds: int = 1
    runs: int = 16
    read: int = 4
    designed_runs: int = 5
    candidates: int = 24

    @classmethod
    def smoke(cls) -> Config:
        """Two quick cases."""
        return cls((0,), ROBOTS, runs=3, read=1, designed_runs=1, candidates=4)

    def cases(self) -> list[Case]:
        """Every pair on every arm; which of the two is hidden alternates, and so does the noise."""
        return [
            Case(p, robot, seed, self.runs, self.read, self.designed_runs, self.candidates)
            for seed in range(self.seeds)
            for p in self.pairs
            for robot in self.robots
        ]


@dataclass(frozen=True)
class Case:
    """A pair on an arm."""

    pair: int
    robot: str
    seed: int
    runs: int
    read: int
    designed_runs: int
    candidates: int

    @property
    def duel(self) -> Duel:
        """What is hidden, and its rival."""
        *forms, joint = PAIRS[self.pair]
        turn = self.pair + ROBOTS.index(self.robot) + self.seed
        hidden, rival = forms if turn % 2 == 0 else reversed(forms)
        noise = "white" if (self.pair // 2 + self.seed) % 2 == 0 else "coloured"
        return Duel(self.robot, str(hidden), str(rival), int(joint), noise, self.seed)

    @property
    def key(self) -> tuple[str, ...]:
        """As text, in the order of `KEY`."""
        d = self.duel
        counts = (d.seed, self.runs, self.designed_runs, self.candidates)
        return (d.robot, d.hidden, d.rival, d.noise, *map(str, counts))

    @property
    def wanted(self) -> float:
        """Lambda on the motion at hand that the size is chosen for."""
        rate = WANTED[(self.pair + ROBOTS.index(self.robot) + self.seed) % len(WANTED)]
        return float(4 * norm.ppf(rate) ** 2)


def run_case(case: Case) -> Outcome:
    """Tune the size, count errors, design, execute, and count again."""
    start = time.perf_counter()
    duel = case.duel
    rng = np.random.default_rng([case.seed, *map(ord, "".join(case.key))])
    scene, size = tune(duel, case.wanted, rng)
    at_hand = [scene.record(scene.log, rng, "at_hand") for _ in range(case.runs)]
    tables = [lay(scene, [pair]) for pair in at_hand]
    found = [table.compare(duel) for table in tables]
    in_fit, decisions = _compared(tables, found)
    apart = [_apart(t, f) for t, f in zip(tables, found, strict=True)]
    predicted = [
        confusion(table.shop, (own.trial, own.coefficients, other.trial), rng)
        for table, (own, other) in zip(tables[: case.read], found, strict=False)
    ]
    following = design(tables[0], found[0], rng, case.candidates)
    log = scene.execute(following.motion, rng)
    extended = [
        lay(scene, [pair, scene.record(log, rng, "designed")])
        for pair in at_hand[: case.designed_runs]
    ]
    after = [table.compare(duel) for table in extended]
    then_in_fit, then = _compared(extended, after)
    return {
        "status": "done",
        "size": size,
        "gain": float(np.mean([own.gain for own, _ in found])),
        "separation": float(np.mean(apart)),
        "formula": float(np.mean([error_rate(x) for x in apart])),
        "predicted_fit": float(np.mean([p.by_fit for p in predicted])),
        "predicted_name": float(np.mean([p.by_name for p in predicted])),
        "wrong_fit": sum(lead < 0 for lead in in_fit),
        "wrong_name": sum(d.wrong for d in decisions),
        "designed_separation": following.separation,
        "designed_formula": error_rate(following.separation),
        "designed_predicted": following.error_rate,
        "designed_resolved": following.resolved,
        "designed_wrong_fit": sum(lead < 0 for lead in then_in_fit),
        "designed_wrong_name": sum(d.wrong for d in then),
        "designed_decided": sum(d.decided for d in then),
        "designed_misled": sum(d.misled for d in then),
        "at_hand_decided": sum(d.decided for d in decisions),
        "first_decided": int(then[0].decided),
        "seconds": time.perf_counter() - start,
    }


def runner(out: Path) -> CaseRunner[Case]:
    """What works through the cases, with its lines in `out`/runs.csv."""
    return CaseRunner(run_case, RowFile(out / "runs.csv", KEY, VALUES), "pairs")


def run(config: Config, out: Path, *, workers: int = 1, scheduler: str | None = None) -> RowFile:
    """Do all cases that `out`/runs.csv does not hold yet."""
    todo = runner(out)
    todo.run(config.cases(), workers=workers, scheduler=scheduler)
    return todo.rows


def write(config: Config, rows: RowFile, out: Path) -> None:
    """Leave summary, figure and provenance beside the rows."""
    wanted = {case.key for case in config.cases()}
    chosen = [row for row in rows.rows() if tuple(row[c] for c in KEY) in wanted]
    write_summary(chosen, len(wanted), out)
    Provenance.collect(config, seed=0).write(out / "provenance.json")


@dataclass(frozen=True)
class Options(CaseOptions):
    """Is the predicted chance of naming the wrong rival right, and does one motion decide?

    Attributes:
        seeds: Of every pair and arm.
    """

    study: ClassVar[str] = "discrimination"
    names: ClassVar[tuple[str, ...]] = ("summary.md", "provenance.json", "calibration.png")

    seeds: Count = Config.seeds


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line."""
    options = parse(Options, prog="python -m studies.discrimination", arguments=arguments)
    config = Config.smoke() if options.smoke else Config(seeds=options.seeds)
    out = options.results
    todo = runner(out)
    if is_finished(todo.rows, config.cases(), config, todo.digest):
        print(f"nothing left to do; {out} stays as it is")
        return 0
    with options.held() as results:
        rows = run(config, out, workers=options.workers, scheduler=options.scheduler)
        with results.replaced() as new:
            write(config, rows, new)
    print((out / "summary.md").read_text(encoding="utf-8"))
    return int(all_failed(rows.rows()))


def _apart(table: Table, found: tuple[Score, Score]) -> float:
    """Lambda as read off noisy recordings, the hidden effect for the favourite."""
    own, other = found
    return separation(table.shop, own.trial, own.coefficients, other.trial)


def _compared(
    tables: Sequence[Table], found: Sequence[tuple[Score, Score]]
) -> tuple[list[float], list[Decision]]:
    """By how much the hidden effects fit better than their rivals, and what is named."""
    both = list(zip(tables, found, strict=True))
    return [t.lead_in_fit(pair) for t, pair in both], [t.decision(pair) for t, pair in both]


if __name__ == "__main__":
    leave(main, "studies.discrimination", RESUMES)
