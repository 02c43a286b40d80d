"""Do the 95 % intervals of the effects that a diagnosis names hold what was injected?

    python -m studies.effect_intervals --out results/effect_intervals
                                       [--forms FORM …] [--seeds N] [--workers N] [--smoke]

Arms of the bench, each with one hidden effect whose parameters mean the same to the bench and to
the catalogue. The diagnosis runs with that one name as its only candidate and with one addition at
most; all else is as ever. A run that
was interrupted goes on where it stopped.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import ClassVar

from oed.commands.options import Count, Seed, parse
from oed.diagnosis.diagnose import diagnose
from oed.diagnosis.inference.answer import FoundEffect
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.read_dataset import read_dataset
from oed.process_end import RESUMES, leave
from studies.bench.case import KEY_COLUMNS, Case, NoiseKind
from studies.bench.forms import forms_of
from studies.bench.make_dataset import make_dataset
from studies.bench.plan import TWO_JOINTS
from studies.bench.truth import HiddenTruth
from studies.case_runner import CaseRunner, RowFile, leave_page, work_through
from studies.interval_summary import Interval, packed, page
from studies.study_options import CaseOptions

RUNS = "runs.csv"
VALUE_COLUMNS = ("status", "effect", "intervals", "seconds")
# Forms with a single meaning of their parameters here and in the catalogue.
COMPARED = (
    "stribeck",
    "power_of_speed",
    "one_sided_viscous",
    "constant",
    "loose_gear",
    "load_friction",
    "position_friction",
    "ripple",
    "spring",
    "tilted_base",
    "rotor",
    "neighbour_motor",
    "gain",
    "late_torque",
    "lagging_torque",
    "elastic",
    "cooling_start",
    "swinging_warmth",
    "payload",
    "eccentric_encoder",
)
# Noise, and whether every motion is repeated: three quarters are, as in the bench.
SETTINGS: tuple[tuple[NoiseKind, bool], ...] = (
    ("white", True),
    ("coloured", True),
    ("felt", True),
    ("white", False),
    ("felt", True),
    ("white", True),
    ("coloured", True),
    ("coloured", False),
)


@dataclass(frozen=True)
class Config:
    """What is simulated.

    Attributes:
        forms: Keys of the bench's forms.
        seeds: Data sets of each form; settings and arms take turns.
        first_seed: Seed of the first.
    """

    forms: tuple[str, ...] = COMPARED
    seeds: int = 4
    first_seed: int = 0


SMOKE = Config(forms=("constant",), seeds=1)


def cases_of(config: Config) -> list[Case]:
    """Data sets, seed by seed: a run that ends early has seen all forms."""
    return list(_cases(config))


def _cases(config: Config) -> Iterator[Case]:
    for seed in range(config.first_seed, config.first_seed + config.seeds):
        for index, form in enumerate(config.forms):
            arms = [r for r in TWO_JOINTS if form in {f.key for f in forms_of("plain", r)}]
            # Every arm meets every setting, before a setting comes back.
            noise, repeated = SETTINGS[(seed + index) % len(SETTINGS)]
            arm = arms[(seed + seed // len(SETTINGS)) % len(arms)]
            yield Case("intervals", arm, (form,), 1.0, noise, repeated, seed)


def work(case: Case) -> dict[str, str | int | float]:
    """A line of the table: the intervals of the effect, or why there are none."""
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / case.label
        (hidden,) = make_dataset(case, data).hidden
        dataset = read_dataset(data)
    model = TorqueModel.standard(dataset.robot)
    effects = diagnose(dataset, model, names=(hidden.name,), most=1, seed=case.seed).effects
    intervals = compare(hidden, effects[0], dataset.robot.n) if effects else []
    status = "done" if intervals else "not named"
    if effects and not intervals:
        status = f"named at joint {effects[0].joint}"
    return {
        "status": status,
        "effect": hidden.name,
        "intervals": packed(intervals),
        "seconds": round(time.perf_counter() - start, 1),
    }


def compare(hidden: HiddenTruth, found: FoundEffect, joints: int) -> list[Interval]:
    """Estimates of a found effect beside what was injected; none if it sits elsewhere."""
    truths = hidden.in_catalogue
    if hidden.name == "torque_gain" and joints == 2 and found.joint != hidden.joint:
        # No motion tells gain 1 + e of one joint from gain 1 / (1 + e) of the other.
        truths = {key: 1 / (1 + value) - 1 for key, value in truths.items()}
    elif hidden.joint not in (None, found.joint):
        return []
    return [
        Interval(pattern.rstrip("_*"), truth, p.value, p.std)
        for pattern, truth in truths.items()
        for p in found.parameters
        if p.std is not None and fnmatchcase(p.name, pattern)
    ]


@dataclass(frozen=True)
class Options(CaseOptions):
    """How often do the intervals of named effects hold what was injected?

    Attributes:
        forms: Of the bench, by key.
        seeds: Data sets of each form.
        first_seed: Seed of the first.
    """

    study: ClassVar[str] = "effect_intervals"
    names: ClassVar[tuple[str, ...]] = ("summary.md", "provenance.json")

    forms: tuple[str, ...] = COMPARED
    seeds: Count = Config.seeds
    first_seed: Seed = Config.first_seed

    def __post_init__(self) -> None:
        super().__post_init__()
        if unknown := set(self.forms) - set(COMPARED):
            raise ValueError(
                f"--forms {' '.join(sorted(unknown))}: there are {', '.join(COMPARED)}"
            )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 1 if all failed, else 0."""
    options = parse(Options, prog="python -m studies.effect_intervals", arguments=arguments)
    config = SMOKE if options.smoke else Config(options.forms, options.seeds, options.first_seed)
    rows = RowFile(options.results / RUNS, KEY_COLUMNS, VALUE_COLUMNS)
    runner = CaseRunner(work, rows, "effect intervals")
    return work_through(
        runner,
        cases_of(config),
        options,
        config,
        lambda out: leave_page(page(rows.rows()), config, config.first_seed, out),
    )


if __name__ == "__main__":
    leave(main, "studies.effect_intervals", RESUMES)
