"""The comparison at its smallest: rows, resumption, failure as a row, summary and figure."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from studies import compare_optimisers, optimality_bound
from studies.case_runner import CaseRunner, Outcome, RowFile
from studies.compare_optimisers import KEY, VALUES, Config
from studies.optimiser_summary import against_the_paper, group, lines, statements, target_cost

TINY = replace(Config.smoke(), optimisers=("genetic", "cma-es"), evaluations=30, cpu_seconds=0.2)


@dataclass(frozen=True)
class Square:
    number: int

    @property
    def key(self) -> tuple[str, ...]:
        return (str(self.number),)


def square(case: Square) -> Outcome:
    if case.number == 3:
        raise ValueError("three, of all\nnumbers")
    return {"status": "done", "value": case.number**2}


def runner(folder: Path) -> CaseRunner[Square]:
    return CaseRunner(
        square, RowFile(folder / "rows.csv", ("number",), ("status", "value")), "squares"
    )


CASES = [Square(n) for n in range(6)]


def test_a_failed_case_is_a_row(tmp_path: Path) -> None:
    work = runner(tmp_path)
    assert work.run(CASES) == 6
    rows = {row["number"]: row for row in work.rows.rows()}
    assert len(rows) == 6
    assert rows["3"]["status"] == "failed: ValueError: three, of all numbers"
    assert rows["4"] == {"number": "4", "status": "done", "value": "16"}


def test_does_only_what_is_missing_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    work = runner(tmp_path)
    assert work.run(CASES[:4]) == 4
    before = work.rows.path.read_text()
    assert "stay" not in capsys.readouterr().err
    assert work.run(CASES) == 2
    assert "squares: 4 of 6 lines are there and stay" in capsys.readouterr().err
    assert work.rows.path.read_text().startswith(before)
    assert work.run(CASES) == 0


def test_a_line_cut_short_is_done_again(tmp_path: Path) -> None:
    work = runner(tmp_path)
    work.run(CASES[:3])
    whole = work.rows.path.read_text()
    work.rows.path.write_text(whole[:-4])  # killed in the middle of the last line
    assert [row["number"] for row in work.rows.rows()] == ["0", "1"]
    assert work.run(CASES[:3]) == 1
    assert work.rows.path.read_text() == whole


def test_refuses_rows_of_another_study(tmp_path: Path) -> None:
    (tmp_path / "rows.csv").write_text("a,b\n1,2\n")
    with pytest.raises(ValueError, match="has the columns"):
        runner(tmp_path).run(CASES)


def test_runs_on_processes(tmp_path: Path) -> None:
    work = CaseRunner(abs_of, RowFile(tmp_path / "rows.csv", ("number",), ("status",)), "cases")
    assert work.run(CASES, workers=2) == 6
    assert work.rows.done() == {(str(n),) for n in range(6)}


def abs_of(case: Square) -> Outcome:
    return {"status": f"done {abs(case.number)}"}


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("comparison")
    todo = compare_optimisers.runner(out)
    todo.run(TINY.cases())
    compare_optimisers.write(TINY, todo.rows, out)
    return out


def test_leaves_rows_summary_figure_and_provenance(finished: Path) -> None:
    rows = RowFile(finished / "runs.csv", KEY, VALUES).rows()
    assert len(rows) == len(TINY.cases()) == 4
    assert not any(row["status"].startswith("failed") for row in rows)
    for row in rows:
        longest = compare_optimisers.LONGEST * TINY.cpu_seconds
        assert int(row["evaluations"]) >= 30 or float(row["cpu_s"]) >= longest
        assert float(row["certified_violation"]) < 1e-9
        assert float(row["value"]) <= float(row["value_at_evaluations"]) * (1 + 1e-6)
    for name in (
        "summary.md",
        "summary.csv",
        "target_hits.png",
        "target_hits.pdf",
        "provenance.json",
    ):
        assert (finished / name).stat().st_size > 0
    # No hit and yet a cost of hits is no contradiction, where runs go on after the budget.
    assert "in the whole of their runs" in (finished / "summary.md").read_text()


def test_resumes_without_losing_or_repeating_a_row(finished: Path, tmp_path: Path) -> None:
    text = (finished / "runs.csv").read_text()
    (tmp_path / "runs.csv").write_text("".join(text.splitlines(keepends=True)[:3]))
    compare_optimisers.runner(tmp_path).run(TINY.cases())
    again = RowFile(tmp_path / "runs.csv", KEY, VALUES)
    assert again.done() == {case.key for case in TINY.cases()}
    assert len(again.rows()) == 4


def row(optimiser: str, seed: int, cost: float, status: str = "done") -> dict[str, str]:
    return {
        "problem": "scara", "class": "fourier", "criterion": "J_k", "optimiser": optimiser,
        "seed": str(seed), "evaluations_budget": "10", "cpu_budget_s": "1.0", "status": status,
        "evaluations": "10", "cpu_s": "1.0", "certified_violation": "-0.1",
        "history": f"2:0.1:{cost + 1} 8:0.5:{cost}",
    }  # fmt: skip


def test_says_who_wins_and_who_cannot_be_told_apart() -> None:
    rng = np.random.default_rng(0)
    rows = [
        row(name, seed, cost + 0.01 * rng.standard_normal())
        for name, cost in (("best", 1.0), ("equal", 1.0), ("worse", 2.0))
        for seed in range(30)
    ]
    sentence = statements(group(rows), (10.0, 1.0))[0]
    assert "ahead of worse" in sentence
    assert "not told apart from" in sentence
    assert "**worse**" not in sentence


def test_counts_failures_and_hits() -> None:
    rows = [row("a", 0, 1.0), row("a", 1, 1.5), row("a", 2, 9.0, "failed: X: y")]
    cells = group(rows)
    (line,) = lines(
        ("scara", "fourier", "J_k"), cells[("scara", "fourier", "J_k")], {"scara": 8}, (10.0, 1.0)
    )
    assert (line["seeds"], line["failed"]) == (2, 1)
    assert line["best"] == pytest.approx(10.0)
    assert line["hit_5"] == 0.5
    assert line["expected_cpu_s_5"] == pytest.approx(0.5 + 1.0)


def test_a_target_is_a_ratio_of_condition_or_an_efficiency() -> None:
    assert 10 ** target_cost(1.0, 0.05, "J_k", 8) == pytest.approx(10.5)
    assert 10 ** ((-20.0 - target_cost(-20.0, 0.05, "J_d", 8)) / 8) == pytest.approx(1 / 1.05)


def test_the_bound_study_holds_designs_below_its_bound(tmp_path: Path) -> None:
    assert optimality_bound.main(["--smoke", "--out", str(tmp_path)]) == 0
    text = (tmp_path / "summary.md").read_text()
    assert "certified" in text
    rows = [line.split(",") for line in (tmp_path / "designs.csv").read_text().splitlines()]
    efficiency = rows[0].index("d_efficiency")
    assert all(0 < float(r[efficiency]) < 1 for r in rows[1:] if len(r) == len(rows[0]))


@pytest.mark.filterwarnings("ignore")  # distributed warns about its own sockets and ports
def test_runs_on_a_dask_cluster(tmp_path: Path) -> None:
    from dask.distributed import LocalCluster  # noqa: PLC0415 - slow, and only here

    work = CaseRunner(abs_of, RowFile(tmp_path / "rows.csv", ("number",), ("status",)), "cases")
    with LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        processes=False,
        protocol="tcp",
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
    ) as cluster:
        assert work.run(CASES, scheduler=cluster.scheduler_address) == 6
    assert work.rows.done() == {(str(n),) for n in range(6)}


def test_says_how_often_the_paper_is_beaten_by_its_own_algorithm() -> None:
    rows = [row("genetic", seed, np.log10(value)) for seed, value in enumerate((12.0, 13.0, 15.0))]
    cells = group([{**r, "class": "conservative"} for r in rows])
    (sentence,) = against_the_paper(cells)
    assert "best J_k 12, median 13; 2 of 3 seeds beat the paper's 13.34" in sentence
    assert against_the_paper(group(rows)) == []
