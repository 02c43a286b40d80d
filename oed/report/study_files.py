"""What each study leaves in its folder, and how: all of it or nothing, and no stale file."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from oed.report.json_file import read_json
from oed.report.output_folder import check_output_folder

ROLES = ("estimation", "validation", "test")


@dataclass(frozen=True)
class StudyFiles:
    """The files of a study.

    Attributes:
        study: Its name.
        record: The JSON file that is written last.
        key: That the record of no other study has.
        others: All other files that it may leave, relative to the folder.
    """

    study: str
    record: str
    key: str
    others: tuple[str, ...]

    def are_in(self, folder: Path) -> bool:
        """Whether a folder holds this study's results."""
        try:
            record = read_json(folder / self.record)
        except (OSError, ValueError):
            return False
        return isinstance(record, dict) and self.key in record

    def check(self, folder: Path) -> None:
        """Refuse a folder that cannot be written to, or that holds another study's results.

        Raises:
            ValueError: As `check_output_folder`, or naming the other study.
        """
        check_output_folder(folder)
        for other in STUDIES:
            if other is not self and other.are_in(folder):
                raise ValueError(
                    f"--out {folder}: holds results of studies.{other.study}, which would be lost; "
                    "choose another folder"
                )

    @contextmanager
    def replaced(self, folder: Path) -> Iterator[Path]:
        """A new folder to write to; at the end its files replace this study's earlier ones.

        Whatever goes wrong before, the folder stays as it was. Other files in it stay anyway.
        """
        home = folder.resolve()
        home.parent.mkdir(parents=True, exist_ok=True)
        # A sibling: on the same file system, and as deep, so that relative paths stay true.
        new = home.with_name(f".{home.name}-{os.getpid()}")
        try:
            new.mkdir()
        except PermissionError:
            # Such as a mounted folder: only it may be written.
            home.mkdir(exist_ok=True)
            self._remove(home)
            yield home
            return
        try:
            yield new
            if home.exists():
                self._remove(home)
                _move(new, home, last=self.record)
            else:
                new.replace(home)
        finally:
            shutil.rmtree(new, ignore_errors=True)

    def _remove(self, folder: Path) -> None:
        """Remove this study's files; the record first: a folder that has it is complete."""
        for name in (self.record, *self.others):
            path = folder / name
            path.unlink(missing_ok=True)
            if path.parent != folder and path.parent.is_dir() and not any(path.parent.iterdir()):
                path.parent.rmdir()


def _move(source: Path, target: Path, *, last: str) -> None:
    files = [path.relative_to(source) for path in sorted(source.rglob("*")) if path.is_file()]
    for file in sorted(files, key=lambda file: str(file) == last):
        (target / file).parent.mkdir(parents=True, exist_ok=True)
        (source / file).replace(target / file)


IDENTIFY = StudyFiles(
    "identify",
    "estimate.json",
    "prediction",
    (
        *(f"{kind}_{role}.png" for kind in ("torque", "residual") for role in ROLES),
        "spectrum_estimation.png",
        "parameters.png",
        "convergence.png",
        "parameters.csv",
        "validation.csv",
        "report.html",
    ),
)
FEASIBLE = StudyFiles(
    "feasible",
    "estimate.json",
    "links",
    (
        *(f"residual_{role}.png" for role in ROLES),
        "margins.png",
        "parameters.png",
        "weight.png",
        "links.csv",
        "parameters.csv",
        "validation.csv",
        "parameters.yaml",
        "robot.sdf",
        "robot.urdf",
        "robot.xml",
        "report.html",
    ),
)
CLOSE_LOOP = StudyFiles(
    "close_loop",
    "diagnosis.json",
    "verdict",
    (
        "additions.png",
        "dependence.png",
        "proof.png",
        "spectrum.png",
        "next_experiment/design.json",
        "next_experiment/trajectory.csv",
        "report.html",
    ),
)
DESIGN = StudyFiles(
    "design",
    "design.json",
    "clearance",
    (
        "joint_trajectory.json",
        "joint_trajectory.yaml",
        "motion.csv",
        "motion.html",
        "motion.png",
        "provenance.json",
    ),
)
STUDIES = (IDENTIFY, FEASIBLE, CLOSE_LOOP, DESIGN)
