"""Verdicts of the paper's study: intervals that hold, sources that are found, claims that can fail."""

import numpy as np
import pytest
from scipy import stats

from studies.paper_experiment.claims import CLAIMS, Claim
from studies.paper_experiment.random_effects import (
    Interval,
    mean_interval,
    rate_interval,
    sources_of,
)


def drawn(rng, shape, sizes):
    """Values around zero with known standard deviations; noise of designs and of tests."""
    (P, T, E), (pair, motion, both, noise) = shape, sizes
    return (
        pair * rng.normal(size=(P, 1, 1))
        + motion * rng.normal(size=(1, T, 1))
        + both * rng.normal(size=(P, T, 1))
        + noise * np.sqrt(0.5) * (rng.normal(size=(P, 1, E)) + rng.normal(size=(1, T, E)))
    )


@pytest.mark.parametrize(
    "sizes", [(1, 0, 0, 0.3), (0, 1, 0, 0.3), (1, 1, 0.5, 0.3), (0, 0, 1, 1), (0, 0, 0, 1)]
)
def test_the_interval_holds_the_mean_whatever_is_drawn(sizes):
    rng = np.random.default_rng(1)
    found = [mean_interval(drawn(rng, (10, 6, 2), sizes)) for _ in range(600)]
    held = np.mean([f.lower < 0 < f.upper for f in found])
    # Below 0.93 is beyond what 600 trials of 0.95 leave to chance; interaction alone is counted
    # twice by intent.
    assert 0.93 < held < (0.98 if sizes[0] + sizes[1] else 1.0)


def test_without_test_motions_it_is_student_s():
    y = np.random.default_rng(2).normal(1.0, 2.0, size=(9, 1, 4))
    expected = stats.ttest_1samp(y.mean(axis=(1, 2)), 0).confidence_interval(0.95)
    found = mean_interval(y)
    np.testing.assert_allclose((found.lower, found.upper), expected, rtol=1e-12)


def test_each_source_is_found_and_told_from_noise():
    rng = np.random.default_rng(3)
    sizes = np.array([2.0, 3.0, 4.0, 1.5])
    # Few of each, so that the interaction weighs on the means of pairs and of motions.
    found = [sources_of(drawn(rng, (10, 8, 4), sizes)) for _ in range(300)]
    squares = np.mean([[f.pair**2, f.motion**2, f.both**2, f.noise**2] for f in found], axis=0)
    np.testing.assert_allclose(np.sqrt(squares), sizes, rtol=0.06)


def test_noise_alone_is_not_taken_for_designs_or_motions():
    rng = np.random.default_rng(4)
    found = [sources_of(drawn(rng, (10, 8, 2), (0, 0, 0, 1))) for _ in range(200)]
    # What is negative is cut: half of the chance that is left shows, a few per cent of the noise.
    assert np.mean([f.pair**2 for f in found]) < 0.1
    assert np.mean([f.motion**2 for f in found]) < 0.1
    assert abs(np.mean([f.noise**2 for f in found]) - 1) < 0.1


@pytest.mark.parametrize("hits", [0, 3, 12])
def test_a_rate_of_independent_draws_is_the_exact_binomial_one(hits):
    found = rate_interval(np.arange(12)[:, None] < hits)
    expected = stats.binomtest(hits, 12).proportion_ci(0.95, "exact")
    np.testing.assert_allclose(
        (found.lower, found.upper), (100 * expected.low, 100 * expected.high), atol=1e-9
    )


def test_draws_that_are_alike_within_their_cluster_count_once():
    clusters = np.arange(10)[:, None] < 4
    alike = rate_interval(np.repeat(clusters, 8, axis=1))
    assert alike == rate_interval(clusters)


def test_a_verdict_has_three_outcomes_and_a_size():
    claim = Claim("s", "q", "", "r", low=1.0)
    assert claim.verdict(Interval(2.0, 1.1, 3.0)) == "confirmed"
    assert claim.verdict(Interval(1.5, 0.5, 3.0)) == "not told apart"
    # An effect of the right sign that is too small to matter refutes.
    assert claim.verdict(Interval(0.5, 0.2, 0.9)) == "refuted"
    within = Claim("s", "q", "", "r", low=-1.0, high=1.0)
    assert within.verdict(Interval(0.0, -0.5, 0.5)) == "confirmed"
    assert within.verdict(Interval(-2.0, -3.0, -1.0)) == "refuted"
    assert within.verdict(Interval(0.0, -3.0, 0.5)) == "not told apart"


def test_every_claim_can_be_confirmed_and_refuted():
    for claim in CLAIMS:
        ends = [end for end in (claim.low, claim.high) if np.isfinite(end)]
        assert ends, claim.statement
        verdicts = {
            claim.verdict(Interval(x, x - 1e-6, x + 1e-6))
            for end in ends
            for x in (end - 1e-3, end, end + 1e-3)
        }
        assert verdicts == {"confirmed", "refuted", "not told apart"}, claim.statement
    assert len({claim.statement for claim in CLAIMS}) == len(CLAIMS)
