"""What the evidence says is the likelihood ratio of normal residuals, by independent samples."""

import numpy as np
import pytest
from scipy.stats import norm

from oed.checkup.change import Change
from oed.checkup.repair import Weighing
from oed.checkup.suspicion import Suspicion
from oed.checkup.trial import Outcome

NONE = Change.none(2)
SUSPICION = Suspicion("sign", "a fault", "a remedy", NONE)


def outcome(*residual):
    """Of torques of 1 N m."""
    left = np.array(residual)
    return Outcome(NONE, left, left, np.zeros(3))


def weighing(counts, before, *after):
    return Weighing(before, (SUSPICION,) * len(after), after, np.array(counts, dtype=float))


def test_the_evidence_is_twice_the_log_of_the_likelihood_ratio():
    rng = np.random.default_rng(7)
    left, more = 0.1 * rng.normal(size=(200, 2)), 0.2 * rng.normal(size=(200, 2))
    sizes = [np.sqrt(np.mean(x**2, axis=0)) for x in (left, more)]
    ratio = norm.logpdf(left, scale=sizes[0]).sum() - norm.logpdf(more, scale=sizes[1]).sum()
    found = weighing((200, 200), outcome(*sizes[1]), outcome(*sizes[0]))
    assert found.over(found.before) == pytest.approx(2 * ratio)


# A residual halved at one joint: 2 log of the ratio is 2 log 2 = 1.386 an independent sample.
@pytest.mark.parametrize(
    ("samples", "suspected", "repairs"),
    [(7, 1, False), (8, 1, True), (10, 20, False), (12, 20, True)],  # beyond 10, and 10 + 2 log 20
)
def test_a_repair_needs_very_strong_evidence_and_more_of_it_the_more_is_suspected(
    samples, suspected, repairs
):
    rest = (outcome(0.2, 0.1),) * (suspected - 1)
    found = weighing((samples, samples), outcome(0.2, 0.1), outcome(0.1, 0.1), *rest)
    assert found.repairs is repairs


@pytest.mark.parametrize(
    ("before", "after", "mended"),
    [(0.2, 0.15, False), (0.2, 0.14, True), (2.0, 0.75, False), (2.0, 0.7, True)],
)
def test_a_repair_explains_most_of_what_was_left_and_most_of_the_torque(before, after, mended):
    found = weighing((1e4, 1e4), outcome(before, 0.1), outcome(after, 0.1))
    assert found.repairs is mended
