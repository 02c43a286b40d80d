"""The study of free frequencies at its smallest: rows, proofs, resumption, summary."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from oed.design.design import prove
from oed.report.comparison_plots import plot_dependence
from studies import free_frequencies
from studies.case_runner import RowFile, is_finished
from studies.free_frequencies import KEY, VALUES, Case, Config, build_problem
from studies.free_frequency_summary import dependence_lines, hit_lines, panels

TINY = replace(Config.smoke(), reference_seeds=1, cpu_seconds=(0.2, 0.2))
REFERENCE = (4.0, 10.0)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("free_frequencies")
    todo = free_frequencies.runner(out)
    todo.run(TINY.cases())
    free_frequencies.write(TINY, todo.rows, out)
    return out


def test_every_row_is_proven_and_can_be_built_again(finished: Path) -> None:
    rows = RowFile(finished / "runs.csv", KEY, VALUES).rows()
    assert len(rows) == len(TINY.cases()) == 4
    for row, case in zip(rows, TINY.cases(), strict=True):
        assert float(row["certified_violation"]) <= 0.0
        assert float(row["largest_amplitude"]) <= case.amplitude_bound
        z = np.array([float(x) for k in ("amplitude", "frequency") for x in row[k].split()])
        problem = build_problem(case)
        again = 10 ** problem.cost(z) if case.criterion == "J_k" else -problem.cost(z)
        assert again == pytest.approx(float(row[case.criterion]), rel=1e-6)
        np.testing.assert_allclose(prove(problem, z)[0], z, rtol=1e-6, atol=1e-9)
    for name in ("summary.md", "dependence.png", "dependence.pdf", "provenance.json"):
        assert (finished / name).stat().st_size > 0
    # A narrower bound may do better than this one: the best of all is in the table by bounds.
    assert "Best of the runs at this bound" in (finished / "summary.md").read_text()


def test_resumes(finished: Path, tmp_path: Path) -> None:
    text = (finished / "runs.csv").read_text()
    (tmp_path / "runs.csv").write_text("".join(text.splitlines(keepends=True)[:4]))
    todo = free_frequencies.runner(tmp_path)
    todo.run(TINY.cases())
    rows = todo.rows
    assert rows.done() == {case.key for case in TINY.cases()}
    assert rows.path.read_text().startswith("".join(text.splitlines(keepends=True)[:4]))


def test_the_reference_is_run_once_at_each_seed() -> None:
    cases = Config().cases()
    assert len({case.key for case in cases}) == len(cases)
    at_reference = [c for c in cases if (c.amplitude_bound, c.horizon) == Config.reference]
    assert len(at_reference) == 2 * Config.reference_seeds


def row(amplitude: float, value: float, cpu_s: float = 10.0) -> dict[str, str]:
    return {
        "amplitude_bound": str(amplitude), "horizon": "10.0", "criterion": "J_k", "seed": "0",
        "status": "proven feasible; 1 chains, 20 local solutions; budget used up",
        "cpu_s": str(cpu_s), "J_k": str(value), "largest_amplitude": "1.0",
        "history": f"5:1:{np.log10(20.0)} 50:{cpu_s / 2}:{np.log10(value)}",
    }  # fmt: skip


def test_counts_successes_time_and_local_solutions() -> None:
    rows = [row(4.0, 6.9), row(4.0, 8.0)]
    line = hit_lines(rows, {"J_k": 6.9, "J_d": np.nan})[1]
    assert (line["runs"], line["hit"]) == (2, 1)
    assert line["expected CPU [s]"] == pytest.approx(5.0 + 10.0)
    assert line["per local solution"] == pytest.approx(1 / (10 + 20))


def test_a_wider_bound_is_never_worse() -> None:
    rows = [row(1.0, 7.0), row(2.0, 9.0), row(4.0, 6.0)]
    found = dependence_lines(rows, REFERENCE, "amplitude_bound")
    assert [line["J_k"] for line in found] == [7.0, 9.0, 6.0]
    assert [line["J_k at_most"] for line in found] == [7.0, 7.0, 6.0]
    panel = panels(rows, REFERENCE)[0]
    np.testing.assert_array_equal(panel.best_values, [7.0, 7.0, 6.0])


def test_no_panel_is_refused() -> None:
    with pytest.raises(ValueError, match="no panel"):
        plot_dependence([])


def test_a_case_says_what_it_is() -> None:
    assert Case(4.0, 10.0, "J_k", 3, 60.0).key == ("4.0", "10.0", "J_k", "3", "60.0")


def test_a_finished_study_is_left_as_it_is(
    finished: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(Config, "smoke", lambda: TINY)
    before = {path: path.read_bytes() for path in finished.iterdir()}
    assert free_frequencies.main(["--smoke", "--out", str(finished)]) == 0
    assert "nothing left to do" in capsys.readouterr().out
    assert {path: path.read_bytes() for path in finished.iterdir()} == before


def test_a_study_with_a_case_to_do_or_another_configuration_is_not_finished(finished: Path) -> None:
    rows = RowFile(finished / "runs.csv", KEY, VALUES)
    assert is_finished(rows, TINY.cases(), TINY)
    more = replace(TINY, reference_seeds=2)
    assert not is_finished(rows, more.cases(), more)
    fewer = replace(TINY, criteria=("J_k",), cpu_seconds=(0.2,))
    assert not is_finished(rows, fewer.cases(), fewer)
