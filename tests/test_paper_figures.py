"""The paper's experiment at smoke size, twice; and every figure from the results that are kept."""

import importlib
import shutil

import numpy as np
import pytest

from oed.report.json_file import read_json, write_json
from oed.report.table import read_csv, write_csv
from paper_figures.writing import NAMES, RESULTS, write_all
from studies.paper_experiment import values as paper
from studies.paper_experiment.claims import CLAIMS
from studies.paper_experiment.experiment import main
from studies.paper_experiment.writing import FILES, OF_A_RUN, keep_provenance


def run(folder, cache):
    assert main(["--smoke", "--out", str(folder), "--cache", str(cache)]) == 0


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    run(folder / "out", folder / "cache")
    return folder / "out"


def left(folder):
    return {name: (folder / name).read_bytes() for name in FILES}


def test_a_rerun_from_nothing_leaves_the_same_bytes(results):
    before = left(results)
    shutil.rmtree(results.parent / "cache")
    run(results, results.parent / "cache")
    assert left(results) == before


def test_a_provenance_is_new_where_a_result_is(results, tmp_path):
    old, new = tmp_path / "old", tmp_path / "new"
    shutil.copytree(results, old)
    shutil.copytree(results, new)
    told = read_json(results / "provenance.json")
    assert told.keys() >= set(OF_A_RUN)
    later = told | dict.fromkeys(OF_A_RUN, "another")
    write_json(new / "provenance.json", later)
    keep_provenance(new, old)
    assert read_json(new / "provenance.json") == told
    for changed in (later | {"seed": 1}, later | {"configuration": {}}):
        write_json(new / "provenance.json", changed)
        keep_provenance(new, old)
        assert read_json(new / "provenance.json") == changed
    write_json(new / "provenance.json", later)
    (new / "cells.csv").write_text("other\n")
    keep_provenance(new, old)
    assert read_json(new / "provenance.json") == later


def test_what_is_there_is_read_back(results, capsys):
    run(results, results.parent / "cache")
    said = capsys.readouterr().out
    assert "unchanged" in said
    assert "…" not in said


def test_an_interrupted_run_goes_on_where_it_stopped(results, tmp_path):
    cache = tmp_path / "cache"
    shutil.copytree(results.parent / "cache", cache)
    cases = sorted((cache / "smoke").glob("*.csv"))
    assert [file.stem for file in cases] == [
        "designs_on_arm",
        "exact_limits",
        "searches",
        "test_motions_on_arm",
    ]
    before = [file.read_text().splitlines(keepends=True) for file in cases]
    for file, lines in zip(cases, before, strict=True):
        file.write_text("".join(lines[:3]) + lines[3][:20])
    for file in (cache / "smoke").glob("designs-*.npz"):
        file.unlink()
    run(tmp_path / "out", cache)
    assert [file.read_text().splitlines(keepends=True) for file in cases] == before
    told = left(results) | {"provenance.json": b""}
    assert left(tmp_path / "out") | {"provenance.json": b""} == told


def test_every_number_of_the_paper_stands_beside_ours(results):
    rows = read_csv(results / "comparison.csv")
    published = [row["paper"] for row in rows]
    for value in (paper.J_K, paper.J_D, *paper.VARIANCES[0], *paper.ESTIMATES[1], *paper.RMS[0][2]):
        assert value in published
    for design in ("J_k", "J_d"):
        for wanted in ("sigma_1^2", "P of gamma_v2", "relative rms, test set, joint 2"):
            assert any(r["design"] == design and r["quantity"] == wanted for r in rows)
    assert all(row["from"] <= row["mean of ours"] <= row["to"] for row in rows)


def test_every_registered_claim_is_judged_by_its_interval_and_band(results):
    rows = read_csv(results / "claims.csv")
    assert {row["claim"] for row in rows} == {claim.statement for claim in CLAIMS}
    for row in rows:
        assert row["lower"] <= row["value"] <= row["upper"]
    summary = (results / "summary.md").read_text()
    assert all(claim.band in summary and claim.outside in summary for claim in CLAIMS)
    assert "Where the spread is from" in summary


def test_drake_and_the_fast_loop_agree_where_it_counts(results):
    row = read_csv(results / "drake.csv")[0]
    assert row["position"] < 1e-5  # a tenth of a resolver's step
    assert row["command"] < 1e-2


def test_every_figure_is_drawn_and_its_caption_holds(tmp_path):
    written = write_all(RESULTS, tmp_path)
    for name in NAMES:
        assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert (tmp_path / f"{name}.pdf").read_bytes().startswith(b"%PDF")
    assert len(written) == 2 * len(NAMES) + 1
    assert "figure_11.png" in (tmp_path / "README.md").read_text()


@pytest.mark.parametrize(
    ("figure", "table", "column"),
    [
        ("02", "trajectories", "dq_2"),
        ("03", "generations", "best"),
        ("04", "recursion", "xi_1"),
        ("04", "recursion", "xi_7"),
        ("05", "torques", "predicted_1"),
        ("06", "torques", "predicted_2"),
        ("07", "trajectories", "ddq_1"),
        ("08", "torques", "measured_2"),
        ("09", "trajectories", "q_1"),
        ("10", "torques", "predicted_2"),
        ("11", "torques", "measured_1"),
    ],
)
def test_a_figure_notices_a_wrong_sign(tmp_path, figure, table, column):
    shutil.copytree(RESULTS, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "figures" / f"{table}.csv"
    write_csv(file, [{**row, column: -row[column]} for row in read_csv(file)])
    with pytest.raises(AssertionError):
        importlib.import_module(f"paper_figures.figure_{figure}").draw(tmp_path)


def test_a_figure_notices_a_search_that_could_go_on(tmp_path):
    shutil.copytree(RESULTS, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "figures" / "designs.csv"
    name = "best of a bit's change"
    write_csv(file, [{**row, name: row["J_d"] + 1} for row in read_csv(file)])
    with pytest.raises(AssertionError, match="not converged"):
        importlib.import_module("paper_figures.figure_03").draw(tmp_path)


def test_a_figure_notices_a_limit_that_is_left(tmp_path):
    shutil.copytree(RESULTS, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "figures" / "trajectories.csv"
    rows = read_csv(file)
    assert np.ptp([row["q_1"] for row in rows]) > 0
    write_csv(file, [{**row, "q_1": 2.0} for row in rows])
    with pytest.raises(AssertionError, match="limit"):
        importlib.import_module("paper_figures.figure_02").draw(tmp_path)
