"""A case from beginning to end: make the data set, run the diagnosis on it, hold it to the truth."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from oed.errors import OedError
from oed.process_end import ends_with_this
from oed.report.code_digest import code_digest
from oed.report.json_file import read_json, write_atomically
from studies.bench.case import Case
from studies.bench.make_dataset import make_dataset
from studies.bench.reliability import stated_text
from studies.bench.robots import ROBOTS
from studies.bench.score import error_ratios, score
from studies.bench.truth import Truth

VALUE_COLUMNS = (
    "status",
    "verdict",
    "claims",
    "found",
    "nearly",
    "missed",
    "extra",
    "stated",
    "coordinates_right",
    "covered",
    "compared",
    "size_in_noise",
    "smaller_in_noise",
    "after_to_floor",
    "after_to_before",
    "removed",
    "seconds",
    "code",
)
CODE_DIGITS = 8  # of the digest of the diagnosis' code in a line


class DiagnosisFailed(OedError):
    """The diagnosis did not end well on a data set.

    Attributes:
        code: Its exit code.
    """

    def __init__(self, message: str, code: int) -> None:
        super().__init__(message)
        self.code = code


@dataclass(frozen=True)
class Judge:
    """Works through a case.

    Attributes:
        folder: For data sets, truths and diagnoses, each kind in a folder of its own.
        module: The diagnosis, run as `python -m module --data DIR --out DIR`.
        limit: Longest time that it may take [s].
        keep: Whether the data sets stay for another run.
        options: Of the diagnosis, beside its folders.
    """

    folder: Path
    module: str = "studies.close_loop"
    limit: float = 900.0
    keep: bool = True
    options: tuple[str, ...] = ()

    def __call__(self, case: Case) -> dict[str, str | int | float]:
        """A line of the table."""
        truth = self.prepare(case)
        out = self.folder / "diagnosis" / case.label
        start = time.perf_counter()
        self._diagnose(self._data(case), out)
        seconds = time.perf_counter() - start
        diagnosis = read_json(out / "diagnosis.json")
        assert isinstance(diagnosis, dict)  # noqa: S101  # the format says so
        if not self.keep:
            shutil.rmtree(self._data(case))
        found = score(diagnosis, truth, len(ROBOTS[case.robot].coulomb))
        errors = error_ratios(diagnosis["rms"])
        return {
            "status": "done",
            "verdict": found.verdict,
            "claims": " ".join(found.claims),
            "found": found.found,
            "nearly": found.nearly,
            "missed": found.missed,
            "extra": found.extra,
            "stated": stated_text(found.stated),
            "coordinates_right": _word(found.coordinates_right),
            "covered": found.covered,
            "compared": found.compared,
            "size_in_noise": _rounded(truth.size_in_noise),
            "smaller_in_noise": _rounded(truth.smaller_in_noise),
            "after_to_floor": _rounded(errors.after_to_floor),
            "after_to_before": _rounded(errors.after_to_before),
            "removed": _rounded(errors.removed),
            "seconds": round(seconds, 1),
            "code": code_digest(self.module)[:CODE_DIGITS],
        }

    def prepare(self, case: Case) -> Truth:
        """The truth of a case; its data set is made if it is not there, or by other code."""
        path = self.folder / "truth" / f"{case.label}.json"
        data, made_by = self._data(case), path.with_suffix(".code")
        code = code_digest(make_dataset.__module__)
        known = made_by.read_text(encoding="utf-8") if made_by.is_file() else ""
        if path.is_file() and data.is_dir() and known == code:
            return Truth.read(path)
        shutil.rmtree(data, ignore_errors=True)
        truth = make_dataset(case, data)
        path.parent.mkdir(parents=True, exist_ok=True)
        truth.write(path)
        write_atomically(made_by, code)
        return truth

    def _data(self, case: Case) -> Path:
        return self.folder / "data" / case.label

    def _diagnose(self, data: Path, out: Path) -> None:
        shutil.rmtree(out, ignore_errors=True)
        out.parent.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", self.module, "--data", str(data), "--out", str(out)]
        command += self.options
        done = subprocess.run(  # noqa: S603  # this interpreter, a module of this repository
            command,
            capture_output=True,
            text=True,
            timeout=self.limit,
            check=False,
            env=ends_with_this(),
        )
        if done.returncode != 0 and not (out / "diagnosis.json").is_file():
            last = done.stderr.strip().splitlines()[-1:] or ["no message"]
            raise DiagnosisFailed(f"exit code {done.returncode}: {last[0]}", done.returncode)


def _word(value: bool | None) -> str:
    return "" if value is None else "yes" if value else "no"


def _rounded(value: float) -> float:
    return float(f"{value:.5g}")
