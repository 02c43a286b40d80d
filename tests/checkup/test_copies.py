"""A held-out recording that is one of those fitted, whole or in part, rounded or not."""

import dataclasses

import numpy as np
import pytest

from oed.checkup.copies import copy_finding
from tests.checkup.simulated_arm import dataset, recorded


def test_two_motions_share_nothing():
    assert copy_finding(dataset()).level == "green"


@pytest.mark.parametrize("digits", [15, 6])
def test_a_copy_is_told_though_it_was_written_with_fewer_digits(digits):
    fit = recorded(1, "estimation", "fit")
    q, tau = (np.round(x, digits) for x in (fit.q, fit.tau))
    copy = dataclasses.replace(fit, name="test", role="test", t=fit.t + 3.0, q=q, tau=tau)
    found = copy_finding(dataset(recordings=(fit, copy)))
    assert found.level == "red"
    assert float(str(found.rows[0]["copied [%]"])) > 90
    assert "test (test)" in found.text


def test_a_part_that_overlaps_is_told_with_its_share():
    fit, other = recorded(1, "estimation", "fit"), recorded(2, "validation", "held")
    half = len(fit) // 2
    overlapping = dataclasses.replace(
        other,
        q=np.concatenate([fit.q[:half], other.q[half:]]),
        tau=np.concatenate([fit.tau[:half], other.tau[half:]]),
    )
    found = copy_finding(dataset(recordings=(fit, overlapping)))
    assert found.rows[0]["copied [%]"] == pytest.approx(50, abs=2)


def test_the_same_motion_played_again_is_no_copy():
    fit = recorded(1, "estimation", "fit")
    noise = 0.05 * np.random.default_rng(3).standard_normal(fit.tau.shape)
    again = dataclasses.replace(fit, name="again", role="validation", tau=fit.tau + noise)
    assert copy_finding(dataset(recordings=(fit, again))).level == "green"
