"""`studies.measured`: a line and a paragraph for each data set, and every fault named."""

import pytest

from oed.experiment.write_dataset import write_dataset
from oed.report.json_file import read_json
from oed.report.table import read_csv
from studies import measured
from tests.diagnosis.arm import data_set, stribeck


def test_what_each_data_set_lacks_stands_side_by_side(tmp_path, capsys):
    data, out, reports = (tmp_path / name for name in ("data", "out", "reports"))
    write_dataset(data_set(0, extra=stribeck(1.0)), data / "creeping")
    (data / "broken").mkdir()
    (data / "broken" / "dataset.toml").write_text("format = 1\n")
    given = ["--data", str(data), "--out", str(out), "--reports", str(reports), "--smoke"]
    assert measured.main(given) == 0
    rows = {row["data"]: row for row in read_csv(out / "runs.csv")}
    assert rows["broken"]["status"].startswith("failed")
    row = rows["creeping"]
    record = read_json(reports / "creeping" / "seed_0" / "diagnosis.json")
    assert (row["verdict"], row["joints"]) == (record["verdict"], 2)
    assert "stribeck (joint 1)" in row["named"]
    assert row["test_after"] < row["test_before"]
    assert row["test_worst_joint"] == pytest.approx(
        max(
            new / old
            for new, old in zip(
                record["rms"]["after"]["test"], record["rms"]["before"]["test"], strict=True
            )
        ),
        abs=1e-3,
    )
    page = (out / "summary.md").read_text()
    assert "## creeping" in page
    assert "stribeck (joint 1)" in page
    assert "broken: failed" in page
    # What is done is not done again.
    (data / "creeping" / "dataset.toml").unlink()
    assert measured.main(given) == 0
    assert "## creeping" in capsys.readouterr().out


def test_a_folder_without_data_sets_is_refused_in_a_line(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(measured, "data_sets", lambda _: ())
    assert measured.main(["--out", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_folder_that_is_not_there_is_refused_before_anything_is_run(tmp_path, capsys):
    out = tmp_path / "out"
    with pytest.raises(SystemExit):
        measured.main(["--data", str(tmp_path / "nowhere"), "--out", str(out)])
    assert "nowhere: no such folder" in capsys.readouterr().err
    assert not out.exists()
