"""The study of rivals at its smallest: rows, resumption, and the statistics of its summary."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom

from oed.dynamics.motion import Motion
from studies import discrimination
from studies.bench.arm import PERIOD
from studies.case_runner import RowFile
from studies.discrimination import KEY, VALUES, Config
from studies.discrimination_summary import agreement, clopper_pearson
from studies.rival_experiment import at_control_period


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("discrimination")
    assert discrimination.main(["--smoke", "--out", str(out)]) == 0
    return out


def test_every_case_is_a_row_with_rates(finished: Path) -> None:
    rows = RowFile(finished / "runs.csv", KEY, VALUES).rows()
    assert [row["status"] for row in rows] == ["done", "done"]
    for row in rows:
        assert 0 <= float(row["predicted_name"]) <= 1
        assert float(row["designed_separation"]) > float(row["separation"])
    # Which of the two is hidden alternates.
    assert {row["hidden"] for row in rows} == {"constant", "one_sided_viscous"}
    for name in ("summary.md", "calibration.png", "provenance.json"):
        assert (finished / name).stat().st_size > 0


def test_resumes(finished: Path, tmp_path: Path) -> None:
    text = (finished / "runs.csv").read_text()
    (tmp_path / "runs.csv").write_text(text)
    rows = discrimination.run(Config.smoke(), tmp_path)
    assert rows.path.read_text() == text


def test_no_case_is_made_twice() -> None:
    cases = Config(seeds=2).cases()
    assert len({case.key for case in cases}) == len(cases) == 40


@pytest.mark.parametrize(("hits", "trials"), [(0, 10), (3, 10), (19, 20), (20, 20)])
def test_interval_of_a_share_has_its_tails(hits: int, trials: int) -> None:
    low, high = clopper_pearson(hits, trials)
    if hits:
        assert binom.sf(hits - 1, trials, low) == pytest.approx(0.025)
    if hits < trials:
        assert binom.cdf(hits, trials, high) == pytest.approx(0.025)
    with pytest.raises(ValueError, match="hits=3"):
        clopper_pearson(3, 2)


def test_agreement_tells_bias_from_chance() -> None:
    rng = np.random.default_rng(0)
    rates = rng.uniform(0.05, 0.4, 200)
    wrong = rng.binomial(50, rates)
    rows = [
        {"p": str(p), "q": str(p + 0.3), "k": str(k), "n": "50"}
        for p, k in zip(rates, wrong, strict=True)
    ]
    right, biased = (agreement(rows, column, "k", "n") for column in "pq")
    assert abs(right["difference"]) < 2 * right["half width"] < 0.03
    assert right["beyond 5 points and chance"] <= 4
    assert biased["difference"] == pytest.approx(0.3, abs=0.02)
    assert biased["beyond 5 points and chance"] > 180


def test_a_designed_motion_is_brought_to_the_controllers_grid() -> None:
    t = np.arange(250) / 250 * 2.0
    phase = np.pi * t[:, None]
    coarse = Motion(t, np.sin(phase), np.pi * np.cos(phase), -(np.pi**2) * np.sin(phase))
    fine = at_control_period(coarse)
    assert len(fine) == 2.0 / PERIOD
    phase = np.pi * fine.t[:, None]
    np.testing.assert_allclose(fine.q, np.sin(phase), atol=1e-7)
    np.testing.assert_allclose(fine.dq, np.pi * np.cos(phase), atol=1e-4)
    np.testing.assert_allclose(fine.ddq, -(np.pi**2) * np.sin(phase), atol=2e-3)
