"""The comparison at its smallest: rows, resumption, failure as a row, summary and figure."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from oed.design.optimisers import interior_point
from oed.design.optimisers.result import Budget, HistoryPoint
from studies import compare_optimisers, optimality_bound
from studies.case_runner import CaseRunner, Outcome, RowFile
from studies.compare_optimisers import Config, Stage
from studies.optimiser_comparison import Cell, cells_of, compare
from studies.optimiser_runs import (
    APART,
    KEY,
    VALUES,
    build_problem,
    improvements,
    judged,
    spaced,
)
from studies.optimiser_summary import best_rows, hit_rows, reached_rows, said_rows
from studies.optimiser_targets import best_known

TINY = Config((Stage(0.2, 2, ("genetic", "hopping"), (("paper", "J_k"),)),))


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
    assert all(float(row["certified_violation"]) < 1e-9 for row in rows)
    for name in ("summary.md", "target_hits.png", "target_hits.pdf", "provenance.json"):
        assert (finished / name).stat().st_size > 0


def test_resumes_without_losing_or_repeating_a_row(finished: Path, tmp_path: Path) -> None:
    text = (finished / "runs.csv").read_text()
    (tmp_path / "runs.csv").write_text("".join(text.splitlines(keepends=True)[:3]))
    compare_optimisers.runner(tmp_path).run(TINY.cases())
    again = RowFile(tmp_path / "runs.csv", KEY, VALUES)
    assert again.done() == {case.key for case in TINY.cases()}
    assert len(again.rows()) == 4


def test_a_run_serves_every_shorter_budget() -> None:
    stages = (Stage(1.0, 3, ("a", "b")), Stage(10.0, 2, ("a",)))
    cases = Config(tuple(replace(stage, cells=(("paper", "J_k"),)) for stage in stages)).cases()
    made = [(case.optimiser, case.seed, case.seconds, case.read_at) for case in cases]
    once = {("b", 0, 1.0, ()), ("b", 1, 1.0, ()), ("a", 2, 1.0, ()), ("b", 2, 1.0, ())}
    assert set(made) == once | {("a", 0, 10.0, (1.0,)), ("a", 1, 10.0, (1.0,))}
    assert len(made) == len(set(made))


def test_a_search_is_worth_more_than_its_start_before_a_local_solution_ends() -> None:
    problem = build_problem("paper", "J_k")
    problem.asked.clear()
    result = interior_point.optimise(problem, Budget(evaluations=40), np.random.default_rng(0))
    found = judged(problem, problem.asked)
    assert len(found) >= 35  # every point at which IPOPT asked
    for point, z in found[::7]:
        assert point.cost == problem.cost(z)
        assert problem.certificate(z).is_feasible
    start = result.history[0].cost
    assert min(point.cost for point, _ in found[:30]) < start - 0.3  # J_k is halved, and better


def test_points_close_in_time_are_judged_once() -> None:
    z = np.zeros(1)
    asked = [(at, z) for at in (1.0, 1.0 + APART / 2, 1.0 + 2 * APART)] + [(2.0, z * np.nan)]
    assert [at for at, _ in spaced(asked)] == [1.0, 1.0 + 2 * APART]
    assert list(spaced([])) == []


def test_only_what_was_best_in_time_improves() -> None:
    points = [HistoryPoint(0, at, cost) for at, cost in ((3.0, 1.0), (1.0, 2.0), (2.0, 2.5))]
    assert improvements(points, 5.0) == (points[1], points[0])
    assert improvements(points, 2.5) == (points[1],)


def row(
    optimiser: str, seed: int, cost: float, status: str = "done", at: float = 0.5
) -> dict[str, str]:
    return {
        "problem": "paper", "criterion": "J_k", "optimiser": optimiser, "seed": str(seed),
        "cpu_budget_s": "1.0", "status": status, "base": "8", "certified_violation": "-0.1",
        "history": f"2:0.1:{cost + 1} 8:{at}:{cost}",
    }  # fmt: skip


def cell(gains: list[float], others: int = 0) -> Cell:
    """The first of two optimisers better by these decades, with others that change nothing."""
    rows = [row("rival", seed, 1.0 + 0.1 * seed) for seed in range(len(gains))]
    rows += [row("first", seed, 1.0 + 0.1 * seed - gain) for seed, gain in enumerate(gains)]
    rows += [row(f"other {n}", 0, 9.0) for n in range(others)]
    return cells_of(rows)[0]


def test_the_interval_is_that_of_all_pairs_together() -> None:
    gains = [0.3, 0.1, 0.4, 0.2]
    found = compare(cell(gains, others=2), "first", "rival", 1.0)
    assert (found.pairs, found.won) == (4, 4)
    level = 1 - 0.05 / 6  # of six pairs of four optimisers
    truth = stats.ttest_1samp(gains, 0.0).confidence_interval(level)
    np.testing.assert_allclose(np.log10([found.low, found.high]), truth, rtol=1e-9)
    assert np.log10(found.gain) == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("gains", "verdict"),
    [
        ([0.30, 0.31, 0.32], "ahead"),
        ([-0.30, -0.31, -0.32], "behind"),
        ([0.3, 0.31, -0.1], "not told apart"),
        ([0.3], "not told apart"),  # one pair shows nothing
        ([0.0001, 0.0002, 0.0001], "as good"),  # surely ahead, by too little to matter
    ],
)
def test_each_verdict_can_come_out(gains: list[float], verdict: str) -> None:
    assert compare(cell(gains), "first", "rival", 1.0).verdict == verdict


def test_a_gain_in_log_det_is_one_of_information_about_each_parameter() -> None:
    each = replace(cell([0.8, 0.8]), criterion="J_d")
    assert compare(each, "first", "rival", 1.0).gain == pytest.approx(10 ** (0.8 / 8))
    assert each.decades(1.05) == pytest.approx(8 * np.log10(1.05))


def test_hits_and_time_are_counted_to_the_same_limit() -> None:
    rows = [row("a", 0, 0.0, at=0.25), row("a", 1, 0.5), row("a", 2, 9.0, "failed: X: y")]
    late = {**row("a", 3, 0.0, at=5.0), "cpu_budget_s": "10.0"}
    each = cells_of([*rows, late])[0]
    assert each.failed == 1
    short, long = hit_rows(each, 0.0, (1.0, 10.0))
    assert short["within 5%"] == "1 of 3"
    assert short["expected to 5% [s]"] == pytest.approx(0.25 + 1.0 + 1.0)
    assert long["within 5%"] == "1 of 1"
    assert long["expected to 5% [s]"] == pytest.approx(5.0)


def test_a_hopping_that_never_hopped_says_so() -> None:
    made = "1 chain, 7 local solutions, {} hops"
    never = cells_of([row("hopping", seed, 1.0, made.format(0)) for seed in range(2)])[0]
    once = cells_of([row("hopping", seed, 1.0, made.format(seed)) for seed in range(2)])[0]
    assert "(0 hops)" in str(reached_rows(never, (1.0,)))
    assert "(0 hops)" in str(best_rows(never, (1.0,)))
    assert "(0 hops)" not in str(reached_rows(once, (1.0,)))


@pytest.mark.parametrize(
    ("default", "genetic", "beaten", "pay"),
    [
        (1.0, 2.0, "not refuted", "confirmed"),
        (2.0, 1.0, "refuted: genetic", "refuted"),
        (1.0, 1.0, "not refuted", "not shown: interior-point as good genetic"),
    ],
)
def test_what_was_said_can_be_refuted(default: float, genetic: float, beaten: str, pay: str):
    rows = [
        row(name, seed, cost + 0.001 * seed)
        for name, cost in (("interior-point", default), ("genetic", genetic))
        for seed in range(3)
    ]
    (line,) = said_rows(cells_of(rows)[0], (1.0,))
    assert line["beaten by none"] == beaten
    assert line["gradients pay"] == pay


def test_the_target_is_the_best_of_all_studies() -> None:
    poor, good = (cells_of([row("a", 0, cost)])[0] for cost in (3.0, 0.1))
    assert best_known(poor)[0] < 3.0
    assert best_known(good) == (0.1, "this study: a, seed 0")


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
