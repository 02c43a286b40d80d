"""Coverage through the whole pipeline: experiments that are exact but for their noise, counted as they should be."""

import numpy as np
import pytest

from oed.dynamics.motion import Motion
from studies import pipeline_coverage as study
from studies.repeated_experiment import ENCODER, NOISES, Case, simulate, truth_of


@pytest.mark.parametrize("noise", NOISES)
def test_a_log_has_the_noise_that_is_said_and_nothing_else(noise):
    truth = truth_of("ur5")
    (one,) = simulate(Case("ur5", noise, 0)).recordings
    (other,) = simulate(Case("ur5", noise, 1)).recordings
    assert one.repetitions == 3
    assert np.abs(one.q / ENCODER - np.round(one.q / ENCODER)).max() < 1e-6
    moved = np.std(one.q - truth.motion.q, axis=0)
    rest = one.tau - truth.model.torque(truth.parameters, truth.motion)
    if noise == "felt":
        assert (moved > 5 * ENCODER).any()
        return
    assert (moved < ENCODER / np.sqrt(11)).all()
    scale = np.hypot(1.0, 0.0 if noise == "white" else 0.3) * truth.noise
    assert np.std(rest, axis=0) == pytest.approx(scale, rel=0.15)
    assert not np.allclose(one.tau, other.tau)


def test_what_the_arm_feels_moves_it_as_its_equation_says():
    """The torque of the moved arm, less what pushes it, is what the drive is asked for."""
    truth = truth_of("ur5")
    case = Case("ur5", "felt", 2)
    (log,) = simulate(case).recordings
    # Accelerations of what was added to the position, by central differences of rounded positions: only
    # that its size is that of the push is asked.
    change = log.q - truth.motion.q
    stiff = truth.inertia * 25.0**2
    assert np.std(change, axis=0) == pytest.approx(truth.noise / stiff, rel=0.5)
    assert isinstance(truth.motion, Motion)


def test_a_summary_counts_experiments_and_not_intervals():
    def row(arm, k, held):
        words = " ".join(f"p{i}:0.5:{int(h)}" for i, h in enumerate(held))
        return {"arm": arm, "noise": "white", "experiment": str(k), "status": "determined",
                "intervals": words, "seconds": "1.0"}  # fmt: skip

    rows = [row("ur5", k, [k > 0, True, True, True]) for k in range(10)]
    (found,) = study.summary_rows(rows)
    assert found["coverage"] == pytest.approx(39 / 40)
    assert found["least"] == "0.900 (p0)"
    # Ten shares, one of them 3/4 and the rest 1: a deviation of 0.075 over the root of ten.
    assert found["+-"] == pytest.approx(1.96 * 0.075 / np.sqrt(10))
    assert "no" in study.page(rows)


def test_an_experiment_gives_intervals_of_what_would_be_printed():
    row = study.work(Case("ur5", "white", 3))
    found = study.unpacked(str(row["intervals"]))
    assert len(found) > 25
    assert np.mean([held for _, _, held in found]) > 0.75
    assert {"Fc_1", "Fv_1"} <= {name for name, _, _ in found}
