"""Is a data set fit for an estimate, and if not, why?

    python -m studies.check --data DIR --out DIR [--joints A B …] [--cutoff HZ] [--model NAME]

Looks the log over before any fit: signs, units and order by tests, ranges, rate and gaps, noise, what
these recordings cannot determine, and the design that completes them. Leaves check.json and
report.html. Ends with 0 if nothing has to be mended first, and with 3 if something has.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.checkup.checkup import check_dataset
from oed.checkup.completion import design_command, recorded_motion
from oed.checkup.finding import Checkup
from oed.errors import OedError
from oed.experiment.dataset import DataSet
from oed.experiment.processing import ProcessingSettings
from oed.report.check_page import write_check
from oed.report.provenance import Provenance
from oed.report.study_files import CHECK
from studies.from_data_set import DataSetConfig, add_arguments, prepare, say
from studies.interrupt import BAD_INPUT, NO_USABLE_RESULT, leave


@dataclass(frozen=True)
class Config(DataSetConfig):
    """What to look over, and where to leave it."""


@dataclass(frozen=True)
class Checked:
    """A checkup, and what it is of."""

    checkup: Checkup
    dataset: DataSet
    settings: ProcessingSettings


def run(config: Config) -> Checked:
    """Read, process, test; says what it does."""
    dataset, model, settings = prepare(config)
    say(f"checking: {dataset.robot.n} joints, model {config.model!r}")
    return Checked(check_dataset(dataset, model, settings), dataset, settings)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 0 if nothing is to be mended first, 3 if so, 2 on bad input."""
    config = _parse(arguments)
    start = time.perf_counter()
    command = _command(config, str)
    try:
        with CHECK.in_folder(config.out, [config.data]) as results:
            found = run(config)
            with results.replaced() as new:
                write_check(
                    found.checkup,
                    found.dataset,
                    new,
                    Provenance.collect(config, seed=None),
                    motion=recorded_motion(found.dataset, found.settings),
                    # A page goes to others, whose folders are elsewhere.
                    command=_command(config, _shown),
                )
    except (OedError, ValueError, OSError) as error:
        sys.stderr.write(f"studies.check: {error}\n")
        return BAD_INPUT
    _print(found.checkup)
    say(f"to complete these data: {command}")
    say(f"wrote {config.out / 'report.html'} in {time.perf_counter() - start:.1f} s")
    return NO_USABLE_RESULT if found.checkup.level == "red" else 0


def _command(config: Config, shown: Callable[[Path], str]) -> str:
    """The design that completes the data, with paths as they are shown."""
    return design_command(
        shown(config.data),
        shown(config.out / "recorded_motion.json"),
        shown(config.out.with_name(f"{config.out.name}-design")),
        model=config.model,
        joints=config.joints,
    )


def _shown(path: Path) -> str:
    """A path as given, without the folders above the working one."""
    if not path.is_absolute():
        return str(path)
    kept = 2 if path.suffix else 1
    return str(Path(*path.parts[-kept:]))


def _print(checkup: Checkup) -> None:
    for finding in checkup.findings:
        say(f"{finding.level:5s}  {finding.topic}: {finding.line}")


def _parse(arguments: Sequence[str] | None) -> Config:
    parser = argparse.ArgumentParser(prog="python -m studies.check", description=__doc__)
    add_arguments(parser)
    parser.add_argument("--smoke", action="store_true", help="as few samples as carry the band")
    given = vars(parser.parse_args(arguments))
    return Config(**{**given, "joints": tuple(given["joints"])})


if __name__ == "__main__":
    leave(main, "studies.check")
