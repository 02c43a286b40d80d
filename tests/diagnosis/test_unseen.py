"""What a fit leaves of recordings that it has not seen."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.terms.trials import dense, white_group
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of


@pytest.mark.parametrize("names", [(), ("stribeck",), ("stribeck", "torque_offset")])
def test_both_motions_are_left_what_a_fit_of_the_base_model_to_both_leaves(names):
    """What was added stays as the first motion has it."""
    shop = shop_of(data_set(2, extra=stribeck(1.0), repetitions=1))
    joints, seen, unseen = shop.context.n, shop.mean, shop.unseen
    assert unseen.rows is not None
    trials = [trial_of(shop, name, joint) for joint, name in enumerate(names)]
    found = shop.fit(trials, seen, bend=False)
    torque = [seen.torque.copy(), unseen.rows.torque()]
    for trial, coefficients in zip(trials, found.coefficients, strict=True):
        there = dataclasses.replace(trial, group=white_group(trial.effect, unseen.rows))
        torque[0] -= dense(trial, joints, seen.rows.count) @ coefficients
        torque[1] -= dense(there, joints, unseen.rows.count) @ coefficients
    # Reversals are nothing of the arm: the first motion's are fitted, others not.
    idle = np.zeros((joints, unseen.rows.count, seen.nuisances.shape[2]))
    blocks = ([seen.regressor, seen.nuisances], [unseen.white, idle])
    whole = [np.concatenate(b, axis=2) for b in blocks]
    columns = np.vstack([c.reshape(-1, c.shape[2]) for c in whole])
    columns /= np.maximum(np.linalg.norm(columns, axis=0), 1e-12)
    flat = np.concatenate([t.ravel() for t in torque])
    left = np.sum((flat - columns @ np.linalg.lstsq(columns, flat, rcond=1e-9)[0]) ** 2)
    assert found.fit.squares + shop.unseen.left(found).sum() == pytest.approx(left, rel=1e-6)
    moved, price = shop.unseen.given_way(found)
    assert np.sum(shop.unseen.errors(moved) ** 2) + price.sum() < np.sum(
        shop.unseen.errors(found) ** 2
    )
    assert np.all(price >= 0)


def test_what_a_motion_determines_well_hardly_gives_way():
    """Every further recording of it makes the parameters surer, and their fit stay."""
    short, long = (
        shop_of(data_set(3, extra=stribeck(1.0), repetitions=1, roles=roles))
        for roles in (("estimation", "validation"), (*["estimation"] * 6, "validation"))
    )
    shares = []
    for shop in (short, long):
        found = shop.fit([], shop.mean, bend=False)
        as_it_was = np.sum(shop.unseen.errors(found) ** 2)
        shares.append(shop.unseen.left(found).sum() / as_it_was)
    assert shares[0] < shares[1] < 1
    assert shares[1] > 0.9


def test_errors_without_and_with_a_change_between_repetitions_are_of_the_same_rows():
    """Where something else is missing, base parameters give way more to the mean of many rows."""
    shop = shop_of(data_set(3, extra=stribeck(3.0), roles=("estimation", "validation")))
    drift = next(t for t in shop.physical if t.key == ("thermal_drift", 1))
    assert shop.layout_for([drift]) is shop.full is not shop.mean
    without, beside = shop.foretold([], [drift])
    # A joint that does not warm changes next to nothing.
    assert beside == pytest.approx(without, rel=0.01)
