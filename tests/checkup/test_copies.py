"""A held-out recording that is one of those fitted, whole or in part, rounded or not."""

import dataclasses

import numpy as np
import pytest

from oed.checkup.copies import copy_finding, retraced_share
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


def test_the_same_motion_played_again_is_no_copy_and_no_other_motion():
    fit = recorded(1, "estimation", "fit")
    rng = np.random.default_rng(3)
    noise = 0.05 * rng.standard_normal(fit.tau.shape)
    # Another moment of the same way, an encoder that is read anew.
    late = fit.t[:-7] + 0.4 * np.median(np.diff(fit.t))
    q = np.column_stack([np.interp(late, fit.t, x) for x in fit.q.T])
    again = dataclasses.replace(
        fit,
        name="again",
        role="validation",
        t=late,
        q=q + 1e-5 * rng.standard_normal(q.shape),
        tau=(fit.tau + noise)[:-7],
        dq=None,
        ddq=None,
    )
    found = copy_finding(dataset(recordings=(fit, again)))
    assert found.level == "amber"
    assert "again (validation) follows for 100 %" in found.text


def test_the_same_path_at_another_speed_is_another_motion():
    fit = recorded(1, "estimation", "fit")
    slow = dataclasses.replace(
        fit, name="slow", role="validation", t=2.0 * fit.t, tau=fit.tau + 1.0, dq=None, ddq=None
    )
    assert copy_finding(dataset(recordings=(fit, slow))).level == "green"


def test_a_motion_of_which_a_part_is_new_has_its_share():
    fit, other = recorded(1, "estimation", "fit"), recorded(2, "validation", "held")
    half = len(fit) // 2
    q = np.concatenate([fit.q[:half], other.q[half:]])
    mixed = dataclasses.replace(other, q=q, tau=other.tau + 1.0)
    assert retraced_share(mixed, [fit]) == pytest.approx(0.5, abs=0.03)
