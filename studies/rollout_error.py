"""Does a simulation with the found model move like the arm, on arms that were measured?

    python -m studies.rollout_error [--data DIR [DIR …]] [--out results/rollout_error]
                                    [--budget S] [--workers N] [--smoke]

`--data` names data sets, or folders that hold some; the shared ones if not given. Each is calibrated as
`oed calibrate` does it, from its base model with rotors, and simulated from measured states under the
measured torque of its held-out recordings. A second diagnosis, of the found model, says whether
model.json holds what the first had found.

Claim, put down before the results: after 2 s the flange of the augmented model, in bodies that can
exist, is at most a fifth as far from the arm's as that of the robot's file, and never farther than that
of the base model in bodies that can exist. One arm where it is farther refutes it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from oed.commands import calibrate, diagnose
from oed.commands.configurations import Calibrate, Diagnose
from oed.commands.options import Folder, OutFolder, Seed, parse
from oed.export.model_file import NAME
from oed.parallel_map import cpu_seconds
from oed.process_end import RESUMES, leave
from oed.report.input_files import data_digest
from oed.report.json_file import read_json
from studies.case_runner import CaseRunner, Outcome, RowFile, leave_page, work_through
from studies.data_folders import data_sets
from studies.rollout_summary import MODELS, page
from studies.study_options import CaseOptions

# Of each search [s] of CPU time, as in `studies.public_arms`.
BUDGET, SMOKE_BUDGET = 60.0, 1.0
SMOKE_CANDIDATES = ("stribeck", "torque_offset")  # in place of the whole catalogue
SHORT = 12  # digits of a data set's hash
KEY = ("arm", "content", "budget", "seed", "smoke")
VALUES = (
    "status",
    "windows",
    "horizons",
    *(f"{x}_{m}" for m in MODELS for x in ("flange_mm", "joint", "lost", "not_simulated")),
    "named",
    "unnamed",
    "second_round",
    "seconds",
)


@dataclass(frozen=True)
class Config:
    """What is simulated.

    Attributes:
        data_sets: Each with the hash of its content.
        budget: CPU time of each search [s].
        seed: Of everything random.
        smoke: Whether each is only a try.
    """

    data_sets: dict[str, str]
    budget: float
    seed: int
    smoke: bool


@dataclass(frozen=True)
class Options(CaseOptions):
    """Does a simulation with the found model move like the arm, on arms that were measured?

    Attributes:
        data: Data sets, or folders of some; the shared ones if not given.
        reports: Folder for whole calibrations.
        budget: CPU time of each search [s].
        seed: Of everything random.
    """

    study: ClassVar[str] = "rollout_error"
    names: ClassVar[tuple[str, ...]] = ("summary.md", "provenance.json")

    data: tuple[Folder, ...] = ()
    reports: OutFolder = Path("out/rollout_error/reports")
    budget: float = BUDGET
    seed: Seed = 0


@dataclass(frozen=True)
class Case:
    """An arm.

    Attributes:
        arm: Name of its data set's folder, or of the folder above one that is called "data".
        content: Hash of the data set.
        budget: CPU time of the search [s].
        seed: Of everything random.
        smoke: Whether it only shows that it works.
        data: The data set's folder.
        reports: Folder for whole calibrations.
    """

    arm: str
    content: str
    budget: float
    seed: int
    smoke: bool
    data: Path
    reports: Path

    @property
    def candidates(self) -> tuple[str, ...]:
        """Effects that a diagnosis may name; the whole catalogue if empty."""
        return SMOKE_CANDIDATES if self.smoke else ()

    @property
    def key(self) -> tuple[str, ...]:
        """As text, in the order of `KEY`."""
        smoke = "yes" if self.smoke else "no"
        return (self.arm, self.content, f"{self.budget:g}", str(self.seed), smoke)


def work(case: Case) -> Outcome:
    """A line of the table."""
    start = cpu_seconds()
    out = case.reports / case.arm
    calibrate.run(
        Calibrate(
            data=case.data,
            out=out,
            model="rotor",
            to=("numpy",),
            candidates=case.candidates,
            budget=case.budget,
            smoke=case.smoke,
            seed=case.seed,
            quiet=True,
        )
    )
    record = read_json(out / "calibration.json")
    if record["rollout"] is None:
        return {"status": "failed: no held-out recording is long enough"}
    models = record["rollout"]["models"]
    return {
        "status": "done",
        "windows": max(told["windows"] for told in models.values()),
        "horizons": _listed(record["rollout"]["horizons"]),
        **{k: v for m, name in MODELS.items() for k, v in _followed(m, models[name]).items()},
        "named": "; ".join(_place(e["name"], e["joint"]) for e in record["effects"]),
        "unnamed": record["unexplained"],
        "second_round": second_round(case, out),
        "seconds": round(cpu_seconds() - start),
    }


def second_round(case: Case, out: Path) -> float:
    """Largest relative difference of an error of the second diagnosis, before it, to the first's."""
    diagnose.run(
        Diagnose(
            data=case.data,
            out=out / "second_round",
            model=out / "diagnosis" / NAME,
            max_effects=0,
            candidates=case.candidates,
            budget=0.0,
            seed=case.seed,
            smoke=case.smoke,
            quiet=True,
        )
    )
    first, second = (
        read_json(out / folder / "diagnosis.json")["rms"]
        for folder in ("diagnosis", "second_round")
    )
    return max(
        abs(again - there) / there
        for role, errors in first["after"].items()
        for there, again in zip(errors, second["before"][role], strict=True)
    )


def _followed(model: str, told: Mapping[str, Any]) -> dict[str, str | float]:
    if told["not_simulated"] is not None:
        return {f"not_simulated_{model}": told["not_simulated"]}
    return {
        f"flange_mm_{model}": _listed(told["flange_mm"]),
        f"joint_{model}": "; ".join(_listed(own) for own in told["joint"]),
        f"lost_{model}": told["lost"],
    }


def _place(name: str, joint: int | None) -> str:
    return name if joint is None else f"{name}@{joint + 1}"


def _listed(values: Sequence[float]) -> str:
    return " ".join(f"{x:.3g}" for x in values)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line."""
    options = parse(Options, prog="python -m studies.rollout_error", arguments=arguments)
    folders = [folder for given in options.data or (None,) for folder in data_sets(given)]
    budget = SMOKE_BUDGET if options.smoke else options.budget
    cases = [
        Case(
            folder.parent.parent.name if folder.name == "data" else folder.name,
            data_digest(folder)[:SHORT],
            budget,
            options.seed,
            options.smoke,
            folder,
            options.reports,
        )
        for folder in (folders[:1] if options.smoke else folders)
    ]
    content = {case.arm: case.content for case in cases}
    config = Config(content, budget, options.seed, options.smoke)
    rows = RowFile(options.results / "runs.csv", KEY, VALUES)
    runner = CaseRunner(work, rows, "rollouts", data=lambda case: case.data)

    def write(out: Path) -> None:
        leave_page(page(rows.rows_of(case.key for case in cases)), config, options.seed, out)

    return work_through(runner, cases, options, config, write)


if __name__ == "__main__":
    leave(main, "studies.rollout_error", RESUMES)
