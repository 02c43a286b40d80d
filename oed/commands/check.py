"""`oed check`: is a data set fit for an estimate, and if not, why?"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from oed.checkup.checkup import check_dataset
from oed.checkup.completion import design_command, recorded_motion
from oed.checkup.finding import Checkup
from oed.commands.configurations import Check, ModelName
from oed.commands.from_data_set import Prepared, model_name, prepare, prepare_for
from oed.commands.from_log import imported, read_or_imported
from oed.commands.telling import say, speak
from oed.counted import counted
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.settings import ProcessingSettings
from oed.one_thread import on_one_thread
from oed.process_end import NO_USABLE_RESULT
from oed.report.check_page import write_check
from oed.report.provenance import Provenance
from oed.report.study_files import CHECK


@dataclass(frozen=True)
class Checked:
    """A checkup, and what it is of."""

    checkup: Checkup
    dataset: DataSet
    settings: ProcessingSettings
    model: ModelName


@on_one_thread
def check(data: DataSet | str | Path, *, model: ModelName | None = None) -> Checkup:
    """Look a data set over before any fit.

    Args:
        data: A data set, or its folder.
        model: As of `identify`.

    Returns:
        Findings, each green, amber or red with its evidence, and the one cause that a test shows.

    Raises:
        DataSetError: If the folder holds no data set that can be used.
    """
    return _checked(prepare(data, model=model)).checkup


def _checked(prepared: Prepared) -> Checked:
    dataset, settings = prepared.dataset, prepared.settings
    say(f"checking: {counted(dataset.robot.n, 'joint')}")
    checkup = check_dataset(dataset, prepared.model, settings)
    return Checked(checkup, dataset, settings, model_name(prepared.model))


def run(config: Check) -> int:
    """Check and print; leave check.json and report.html where a folder is named.

    Returns:
        3 if something has to be mended first, else 0.
    """
    speak(quiet=config.quiet)
    start = time.perf_counter()
    if config.out is None:
        checkup = _checked(prepare_for(config, read_or_imported(config))).checkup
        _print(checkup)
        print("name a folder by --out for the page, and the motion that completes these data")
    else:
        checkup = _check_into(config, config.out)
        print(f"open {config.out / 'report.html'} ({time.perf_counter() - start:.1f} s)")
    return NO_USABLE_RESULT if checkup.level == "red" else 0


def _check_into(config: Check, out: Path) -> Checkup:
    with CHECK.in_folder(out, config.inputs) as results:
        config = imported(config, out)
        found = _checked(prepare_for(config))
        with results.replaced() as new:
            write_check(
                found.checkup,
                found.dataset,
                new,
                Provenance.collect(config, seed=None),
                motion=recorded_motion(found.dataset, found.settings),
                # A page goes to others, whose folders are elsewhere.
                command=_command(config, out, found.model, _shown),
            )
    _print(found.checkup)
    print(f"to complete these data: {_command(config, out, found.model, str)}")
    return found.checkup


def _print(checkup: Checkup) -> None:
    for finding in checkup.findings:
        print(f"{finding.level:5s}  {finding.topic}: {finding.line}")


def _command(config: Check, out: Path, model: ModelName, shown: Callable[[Path], str]) -> str:
    """The design that completes the data, with paths as they are shown."""
    return design_command(
        shown(config.data),
        shown(out / "recorded_motion.json"),
        shown(out.with_name(f"{out.name}-design")),
        model=model,
        joints=config.joints,
    )


def _shown(path: Path) -> str:
    """A path as given, without the folders above the working one."""
    if not path.is_absolute():
        return str(path)
    kept = 2 if path.suffix else 1
    return str(Path(*path.parts[-kept:]))
