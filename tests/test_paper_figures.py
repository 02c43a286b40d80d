"""The paper's experiment at smoke size, and every figure from what it leaves."""

import numpy as np
import pytest

from oed.report.table import read_csv, write_csv
from paper_figures import figure_02, figure_05
from paper_figures.writing import NAMES, write_all
from studies.paper_experiment import values as paper
from studies.paper_experiment.experiment import main
from studies.paper_experiment.monte_carlo import infeasible


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    assert main(["--smoke", "--out", str(folder / "out"), "--cache", str(folder / "cache")]) == 0
    return folder / "out"


def test_every_figure_is_drawn_and_its_caption_holds(results, tmp_path):
    written = write_all(results, tmp_path)
    for name in NAMES:
        assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert (tmp_path / f"{name}.pdf").read_bytes().startswith(b"%PDF")
    assert len(written) == 2 * len(NAMES) + 1
    assert "figure_11.png" in (tmp_path / "README.md").read_text()


def test_every_number_of_the_paper_stands_beside_one_of_ours(results):
    rows = read_csv(results / "comparison.csv")
    published = [row["paper"] for row in rows]
    for value in (paper.J_K, paper.J_D, *paper.VARIANCES[0], *paper.ESTIMATES[1], *paper.RMS[0][2]):
        assert value in published
    for design in ("J_k", "J_d"):
        for wanted in ("sigma_1^2", "P of gamma_v2", "relative rms, test set, joint 2"):
            assert any(r["design"] == design and r["quantity"] == wanted for r in rows)
    assert all(np.isfinite(row["reproduced"]) for row in rows)


def test_claims_carry_intervals_and_a_verdict(results):
    rows = read_csv(results / "claims.csv")
    assert len({row["claim"] for row in rows}) >= 10
    for row in rows:
        assert row["lower"] <= row["value"] <= row["upper"]
        assert row["verdict"] in ("confirmed", "refuted", "undecided")


def test_drake_and_the_fast_loop_agree_where_it_counts(results):
    row = read_csv(results / "drake.csv")[0]
    assert row["position"] < 1e-6
    assert row["command"] < 1e-2


def test_a_second_run_reads_everything_back(results, capsys):
    cache = results.parent / "cache"
    before = (results / "runs.csv").read_text()
    main(["--smoke", "--out", str(results), "--cache", str(cache)])
    said = capsys.readouterr().out
    assert "unchanged" in said
    assert "…" not in said
    assert (results / "runs.csv").read_text() == before


def test_a_figure_refuses_results_that_break_its_caption(results, tmp_path):
    for file in (results / "figures").iterdir():
        (tmp_path / "figures").mkdir(exist_ok=True)
        (tmp_path / "figures" / file.name).write_bytes(file.read_bytes())
    (tmp_path / "comparison.csv").write_bytes((results / "comparison.csv").read_bytes())
    rows = [dict(row) for row in read_csv(results / "figures" / "trajectories.csv")]
    write_csv(tmp_path / "figures" / "trajectories.csv", [{**r, "q_1": 2.0} for r in rows])
    with pytest.raises(AssertionError, match="limit"):
        figure_02.draw(tmp_path)
    rows = [dict(row) for row in read_csv(results / "figures" / "torques.csv")]
    write_csv(tmp_path / "figures" / "torques.csv", [{**r, "predicted_1": 0.0} for r in rows])
    with pytest.raises(AssertionError):
        figure_05.draw(tmp_path)


def test_an_arm_that_cannot_be_is_told():
    good = np.array([3.9, 0.8, 0.3, 0.14, 2.6, 7.3, 1.5, 0.8])
    assert not infeasible(good)
    for index, value in ((0, -1.0), (1, 30.0), (3, -0.1), (4, -0.2)):
        bad = good.copy()
        bad[index] = value
        assert infeasible(bad)
