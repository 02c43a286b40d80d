"""Which estimator of dynamic parameters is to be trusted when, on simulated arms under control?

    python -m studies.estimators [--workers N] [--scheduler ADDRESS] [--smoke] [--out results/estimators]

Around a base case one factor at a time: noise white, coloured and felt by the arm, encoder, rate, delay,
friction law, excitation. Every estimator works on the same logs. A run that was interrupted goes on where
it stopped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from oed.commands.options import parse
from oed.report.json_file import write_atomically
from oed.report.provenance import Provenance
from oed.report.style import save_figure
from studies.case_runner import CaseRunner, RowFile, all_failed
from studies.estimators.arms import KEYS, SEED
from studies.estimators.conditions import CONDITIONS
from studies.estimators.contest import KEY, METHODS, VALUES, Case, work
from studies.estimators.pictures import PICTURES
from studies.estimators.summary import page
from studies.study_options import CaseOptions

SMALL = ("planar", "quill")  # arms of which a feasible estimate takes seconds, not minutes
FAST = tuple(m for m in METHODS if not m.startswith("feasible"))


@dataclass(frozen=True)
class Config:
    """What is simulated: every arm under every condition.

    Attributes:
        draws: Logs of each condition, by arm.
        conditions: By arm.
        feasible: Conditions in which feasible estimates are made, of the two small arms.
    """

    draws: dict[str, int]
    conditions: dict[str, tuple[str, ...]]
    feasible: tuple[str, ...]


FULL = Config(
    draws={"planar": 6, "quill": 4, "ur5": 4, "panda": 4},
    conditions=dict.fromkeys(KEYS, tuple(CONDITIONS)),
    feasible=("poor motion",),
)
SMOKE = Config(draws={"planar": 2}, conditions={"planar": ("base",)}, feasible=())


def cases_of(config: Config) -> list[Case]:
    """All of a condition together, so that its logs are simulated once."""
    return [
        Case(arm, condition, method, config.draws[arm])
        for arm, conditions in config.conditions.items()
        for condition in conditions
        for method in METHODS
        if method in FAST or (arm in SMALL and condition in config.feasible)
    ]


@dataclass(frozen=True)
class Options(CaseOptions):
    """Which estimator of dynamic parameters is to be trusted when?

    Attributes:
        arms: Keys of the arms; all if not given.
    """

    study: ClassVar[str] = "estimators"
    names: ClassVar[tuple[str, ...]] = (
        "summary.md",
        "provenance.json",
        *(f"{name}.png" for name in PICTURES),
    )

    arms: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        unknown = [name for name in self.arms if name not in FULL.conditions]
        if unknown:
            raise ValueError(
                f"--arms: no arm {unknown[0]!r}; there are {', '.join(FULL.conditions)}"
            )

    @property
    def config(self) -> Config:
        """With the arms that were named."""
        whole = SMOKE if self.smoke else FULL
        kept = {arm: x for arm, x in whole.conditions.items() if not self.arms or arm in self.arms}
        return replace(whole, conditions=kept)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 1 if all failed, else 0."""
    options = parse(Options, prog="python -m studies.estimators", arguments=arguments)
    config = options.config
    with options.held() as results:
        rows = RowFile(options.results / "runs.csv", KEY, VALUES)
        runner = CaseRunner(work, rows, "estimators")
        cases = cases_of(config)
        runner.run(cases, workers=options.workers, scheduler=options.scheduler)
        lines = rows.lines()
        found = [lines[case.key].row for case in cases]
        with results.replaced() as new:
            write_atomically(new / "summary.md", page(found))
            for name, draw in PICTURES.items():
                save_figure(draw(found), new / name, ("png",))
            Provenance.collect(config, seed=SEED).write(new / "provenance.json")
    print(page(found))
    return int(all_failed(found))
