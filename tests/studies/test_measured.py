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
    # What is done is not done again, wherever it lies; what was mended is.
    capsys.readouterr()
    moved = data.rename(tmp_path / "moved")
    manifest = moved / "broken" / "dataset.toml"
    manifest.write_text("format = 2\n")
    given[1] = str(moved)
    assert measured.main(given) == 0
    told = capsys.readouterr()
    assert "1 of 2 lines are there and stay" in told.err
    assert "1 lines of other code or data are done again" in told.err
    assert "## creeping" in told.out
    assert "knows format = 1" in told.out


def test_a_user_s_data_write_nothing_into_the_project_s_results_and_a_failure_is_told(
    tmp_path, monkeypatch, capsys
):
    data = tmp_path / "data" / "dfki_a0"
    data.mkdir(parents=True)
    (data / "dataset.toml").write_text("format = 1\n")
    monkeypatch.chdir(tmp_path)
    committed = tmp_path / "results" / "measured" / "runs.csv"
    committed.parent.mkdir(parents=True)
    known = ",".join(["dfki_a0", "0", "no", "done", *[""] * (len(measured.VALUES) - 1)])
    committed.write_text(f"{','.join((*measured.KEY, *measured.VALUES))}\n{known}\n")
    before = committed.read_bytes()
    assert measured.main(["--data", "data"]) == 1
    assert "dfki_a0: failed: DataSetError" in capsys.readouterr().out
    assert committed.read_bytes() == before
    (row,) = read_csv(tmp_path / "out" / "measured" / "runs.csv")
    # Nor do the committed numbers answer for another folder of the same name.
    assert measured.main(["--data", "data", "--out", "results/measured"]) == 1
    assert row["status"].startswith("failed")


def test_no_data_sets_at_hand_are_told_before_anything_is_run(tmp_path, monkeypatch):
    monkeypatch.setattr(measured, "data_sets", lambda _: ())
    with pytest.raises(ValueError, match="no data sets; name a folder with --data"):
        measured.main(["--out", str(tmp_path / "out")])
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_not_there_is_refused_before_anything_is_run(tmp_path, capsys):
    out = tmp_path / "out"
    with pytest.raises(SystemExit):
        measured.main(["--data", str(tmp_path / "nowhere"), "--out", str(out)])
    assert "nowhere: no such folder" in capsys.readouterr().err
    assert not out.exists()
