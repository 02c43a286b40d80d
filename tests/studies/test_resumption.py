"""Studies of many cases, cut short after their first case: the same rows as in one go, one a key."""

from pathlib import Path
from types import ModuleType

import pytest

from studies import coverage, feasibility_price
from studies.row_file import RowFile

TIMED = {"seconds", "milliseconds"}  # columns that no two runs share


def rows_of(study: ModuleType, out: Path) -> list[dict[str, str]]:
    return RowFile(out / "runs.csv", study.KEY, study.VALUES).rows()


@pytest.mark.parametrize("study", [coverage, feasibility_price], ids=lambda study: study.__name__)
def test_an_interrupted_study_goes_on_where_it_stopped(study: ModuleType, tmp_path: Path) -> None:
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    for out in (whole, cut):
        assert study.main(["--smoke", "--out", str(out)]) == 0
    lines = (cut / "runs.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    (cut / "runs.csv").write_text("".join(lines[:2]) + lines[2][:9], encoding="utf-8")
    assert study.main(["--smoke", "--out", str(cut)]) == 0
    after = (cut / "runs.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    assert after[:2] == lines[:2]  # what was done is not done again
    assert len(after) == len(lines)
    expected, found = (rows_of(study, out) for out in (whole, cut))
    assert len(found) == len(after) - 1  # no key has two
    untimed = [{k: v for k, v in row.items() if k not in TIMED} for row in expected]
    assert [{k: row[k] for k in row.keys() - TIMED} for row in found] == untimed
    assert (cut / "summary.md").is_file()
    assert (cut / "provenance.json").is_file()
