"""The comparison of classes of motions: its verdicts can fail, and it runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from studies import compare_trajectories
from studies.compare_trajectories import Case, pose
from studies.trajectory_summary import interval, judge, summarise

BASE = 10


def rows(gains: list[float], arm: str = "ur5") -> list[dict[str, str]]:
    """A class that gives more information than a series by these factors, seed by seed."""
    values = {
        "fourier 5": [100.0 + seed for seed in range(len(gains))],
        "fourier 20": [90.0 for _ in gains],
        "collocation 40": [100.0 + seed + BASE * np.log10(g) for seed, g in enumerate(gains)],
    }
    return [
        {
            "problem": arm, "trajectory": name, "seed": str(seed), "variables": "7",
            "base": str(BASE), "value": str(value), "J_k": "3", "J_d_continuous": "3",
            "certified_violation": "-1e-9", "evaluations": "9", "cpu_s": "1", "status": "ok",
        }
        for name, each in values.items()
        for seed, value in enumerate(each)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("gains", "verdict"),
    [
        ([1.2, 1.21, 1.22], "wins"),
        ([1.2, 1.2, 0.9], "does not win"),
        ([1.01, 1.01, 1.01], "does not win"),  # sure, and too little to matter
        ([0.8, 0.81, 0.82], "loses"),
        ([1.2], "does not win"),
    ],
)
def test_each_verdict_can_come_out(gains: list[float], verdict: str) -> None:
    text = summarise(rows(gains), 1.0)
    line = next(line for line in text.splitlines() if line.startswith("| ur5 | collocation 40 | f"))
    assert "| fourier 5 |" in line  # the better of the two series
    assert line.endswith(f"| {verdict} |")


def test_the_interval_is_students() -> None:
    differences = np.array([0.3, 0.1, 0.4, 0.2])
    low, high = interval(differences)
    truth = stats.ttest_1samp(differences, 0.0).confidence_interval(0.95)
    np.testing.assert_allclose([low, high], truth, rtol=1e-12)
    assert judge(1.02, 2.0) == "wins"
    assert judge(1.0199, 2.0) == "does not win"


def test_it_runs_at_smoke_size(tmp_path: Path) -> None:
    assert compare_trajectories.main(["--smoke", "--out", str(tmp_path)]) == 0
    assert "collocation 60" in (tmp_path / "summary.md").read_text()


def test_motions_of_arms_start_and_end_at_rest_within_effort_limits() -> None:
    problem = pose(Case("ur5", "collocation 40", 0, 1.0))
    z = problem.random_start(np.random.default_rng(0))
    ends = problem.trajectory.motion(z, np.array([0.0, 10.0]))
    np.testing.assert_allclose([ends.dq, ends.ddq], 0.0, atol=1e-9)
    assert problem.limits_torque
    certificate = problem.certificate(z)
    assert certificate.is_feasible
    assert certificate.torque is not None
