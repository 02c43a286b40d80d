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
    """Check, and leave check.json and report.html; 3 if something has to be mended first."""
    speak(quiet=config.quiet)
    start = time.perf_counter()
    with CHECK.in_folder(config.out, [config.data]) as results:
        found = _checked(prepare_for(config))
        with results.replaced() as new:
            write_check(
                found.checkup,
                found.dataset,
                new,
                Provenance.collect(config, seed=None),
                motion=recorded_motion(found.dataset, found.settings),
                # A page goes to others, whose folders are elsewhere.
                command=_command(config, found.model, _shown),
            )
    for finding in found.checkup.findings:
        print(f"{finding.level:5s}  {finding.topic}: {finding.line}")
    print(f"to complete these data: {_command(config, found.model, str)}")
    print(f"open {config.out / 'report.html'} ({time.perf_counter() - start:.1f} s)")
    return NO_USABLE_RESULT if found.checkup.level == "red" else 0


def _command(config: Check, model: ModelName, shown: Callable[[Path], str]) -> str:
    """The design that completes the data, with paths as they are shown."""
    return design_command(
        shown(config.data),
        shown(config.out / "recorded_motion.json"),
        shown(config.out.with_name(f"{config.out.name}-design")),
        model=model,
        joints=config.joints,
    )


def _shown(path: Path) -> str:
    """A path as given, without the folders above the working one."""
    if not path.is_absolute():
        return str(path)
    kept = 2 if path.suffix else 1
    return str(Path(*path.parts[-kept:]))
