"""What every study that answers a question can be told."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from oed.commands.options import Count, OutFolder
from oed.report.output_folder import check_output_folder
from oed.report.result_folder import ResultFiles, ResultFolder


@dataclass(frozen=True)
class StudyOptions:
    """Where results go, and whether the study only shows that it works.

    Attributes:
        out: Folder for the results; results/STUDY if not given, out/STUDY with --smoke.
        smoke: As small as it can be, to see that it works.
    """

    study: ClassVar[str] = ""
    # What it leaves beside the lines of a study of many cases.
    names: ClassVar[tuple[str, ...]] = ("runs.csv", "summary.md", "provenance.json")

    out: OutFolder | None = None
    smoke: bool = False

    def __post_init__(self) -> None:
        check_output_folder(self.results)

    @property
    def results(self) -> Path:
        """Where the results go: a try must not replace what is kept."""
        home = Path("results" if self.is_kept else "out")
        return home / self.study if self.out is None else self.out

    @property
    def is_kept(self) -> bool:
        """Whether these are results of this project."""
        return not self.smoke

    def held(self, inputs: Sequence[str | Path] = ()) -> AbstractContextManager[ResultFolder]:
        """The folder for the results, for this run alone; as `ResultFiles.in_folder`."""
        files = ResultFiles(self.study, self.names, goes_on=True)
        return files.in_folder(self.results, inputs)


@dataclass(frozen=True)
class CaseOptions(StudyOptions):
    """The same, for a study of many cases.

    Attributes:
        workers: Processes on this machine.
        scheduler: Address of a Dask scheduler that does the work instead: tcp://host:8786.
    """

    workers: Count = 1
    scheduler: str | None = None
