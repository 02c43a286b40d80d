"""`studies.estimators`: the loop obeys Drake, each method finds the truth where it should, counts are right."""

import numpy as np
import pytest

from oed.dynamics.drake_plant import drake_torque
from oed.report.table import read_csv
from studies.estimators import contest, linear, study
from studies.estimators.arms import arm_of
from studies.estimators.conditions import CONDITIONS, logs_of, motion_of
from studies.estimators.loop import SIGN_WIDTH, Disturbances, simulate
from studies.estimators.recipe import Equations, Found


def test_the_controlled_arm_gives_the_torque_that_drake_asks_of_its_motion():
    arm = arm_of("quill")
    reference = motion_of(arm, np.random.default_rng(1))[:3000]
    runs = simulate("quill", arm.truth[None], reference, Disturbances.none(3000, 4))
    motion = runs.motion(0, 1)
    kind = dict(zip(arm.base.names, arm.truth, strict=True))
    coulomb, viscous = ([kind[f"{x}_{j + 1}"] for j in range(4)] for x in ("Fc", "Fv"))
    friction = coulomb * np.tanh(motion.dq / SIGN_WIDTH) + viscous * motion.dq
    expected = drake_torque(arm.robot, motion) + friction
    # The step takes friction at its end: alike where signs do not turn.
    away = np.abs(motion.dq).min(axis=1) > 5 * SIGN_WIDTH
    np.testing.assert_allclose(
        runs.torque[away, :, 0], expected[away], atol=0.02 * np.abs(expected).max(axis=0).min()
    )


def test_what_the_arm_feels_moves_it_and_its_controller_answers():
    logs = {name: logs_of("planar", CONDITIONS[name], 2) for name in ("base", "felt noise")}
    apart = {name: np.std(x.q[0] - x.q[1]) for name, x in logs.items()}
    assert apart["felt noise"] > 3 * apart["base"]


def test_total_least_squares_are_consistent_where_least_squares_are_not():
    rng = np.random.default_rng(0)
    truth = np.array([1.0, -2.0, 0.5])
    clean = rng.normal(size=(20_000, 3))
    scale = np.linalg.norm(clean @ truth) / np.linalg.norm(clean, axis=0).mean()
    y = clean @ truth + 0.5 * scale * rng.normal(size=len(clean))
    equations = Equations(clean + 0.5 * rng.normal(size=clean.shape), y, 1)
    attenuated = linear.ordinary(equations).parameters
    assert np.abs(attenuated / truth).max() < 0.85
    np.testing.assert_allclose(linear.total(equations).parameters, truth, rtol=0.03)


def test_deviations_of_least_squares_are_those_of_many_draws():
    rng = np.random.default_rng(1)
    W, truth = rng.normal(size=(400, 3)) * [1.0, 10.0, 0.1], np.array([1.0, 2.0, 3.0])
    found = [
        linear.ordinary(Equations(W, W @ truth + 0.3 * rng.normal(size=400), 1)) for _ in range(300)
    ]
    spread = np.std([x.parameters for x in found], axis=0)
    half = np.mean([np.diff(x.interval, axis=1)[:, 0] / 2 for x in found], axis=0)
    np.testing.assert_allclose(half, 1.96 * spread, rtol=0.15)


@pytest.mark.parametrize("method", [linear.ridge, linear.truncated])
def test_cross_validation_takes_a_direction_away_that_only_noise_fills(method):
    rng = np.random.default_rng(2)
    shared = rng.normal(size=(300, 1))
    W = np.hstack([shared, shared + 1e-4 * rng.normal(size=(300, 1))])
    y = W @ [1.0, 1.0] + 0.5 * rng.normal(size=300)
    wild = linear.ordinary(Equations(W, y, 1)).parameters
    tame = method(Equations(W, y, 1)).parameters
    assert np.abs(tame - 1).max() < 0.2 < np.abs(wild - 1).max()


def test_every_method_finds_the_arm_on_a_full_motion(tmp_path):
    assert study.main(["--smoke", "--out", str(tmp_path)]) == 0
    rows = {row["method"]: row for row in read_csv(tmp_path / "runs.csv")}
    assert set(rows) == set(study.FAST)
    assert all(row["error"] < 0.02 for row in rows.values())
    # Exact knowledge of controller and encoder: positions tell more than noisy torques.
    assert rows["output error"]["error"] < rows["IDIM-LS"]["error"] / 5
    page = (tmp_path / "summary.md").read_text()
    assert "## Who is best where" in page
    assert (tmp_path / "error.png").stat().st_size > 0


def test_intervals_that_hold_and_logs_that_fail_are_counted(monkeypatch):
    truth = arm_of("planar").truth
    right = Found.of_std(truth, np.ones_like(truth))
    wrong = Found.of_std(truth + 1.0, np.full_like(truth, 1e-3))
    told = [right, wrong, Found.bare(truth), None]
    monkeypatch.setitem(contest.METHODS, "told", lambda *_: told)
    monkeypatch.setattr(contest, "logs_of", lambda *_: None)
    row = contest.work(contest.Case("planar", "base", "told", 4))
    assert (row["covered"], row["intervals"], row["failed"]) == (8, 16, 1)
    monkeypatch.setitem(contest.METHODS, "told", lambda *_: [None] * 4)
    assert contest.work(contest.Case("planar", "base", "told", 4))["status"].startswith("failed")
    with pytest.raises(ValueError, match="no arm 'nobody'"):
        study.Options(arms=("nobody",))
