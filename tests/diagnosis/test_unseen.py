"""What a fit leaves of recordings that it has not seen."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.terms.trials import dense, white_group
from tests.diagnosis.arm import data_set, stribeck
from tests.diagnosis.shop import shop_of, trial_of


def stacked(shop, trials):
    """White columns and torque of both motions, one below the other; reversals of the first alone."""
    rows, unseen = shop.mean.rows, shop.unseen.rows
    joints = shop.context.n
    seen = [shop.mean.regressor, shop.mean.nuisances]
    other = [shop.unseen.white, np.zeros((joints, unseen.count, shop.mean.nuisances.shape[2]))]
    for trial in trials:
        seen.append(dense(trial, joints, rows.count))
        there = dataclasses.replace(trial, group=white_group(trial.effect, unseen))
        other.append(dense(there, joints, unseen.count))
    columns = [np.concatenate(c, axis=2) for c in (seen, other)]
    columns = [c.reshape(-1, c.shape[2]) for c in columns]
    torques = [shop.mean.torque.ravel(), unseen.torque().ravel()]
    return np.vstack(columns), np.concatenate(torques)


@pytest.mark.parametrize("names", [(), ("stribeck",), ("stribeck", "torque_offset")])
def test_both_motions_are_left_what_a_fit_to_both_leaves(names):
    shop = shop_of(data_set(2, extra=stribeck(1.0), repetitions=1))
    trials = [trial_of(shop, name, joint) for joint, name in enumerate(names)]
    found = shop.fit(trials, shop.mean, bend=False)
    columns, torque = stacked(shop, trials)
    lengths = np.maximum(np.linalg.norm(columns, axis=0), 1e-12)
    best = np.linalg.lstsq(columns / lengths, torque, rcond=1e-9)[0]
    left = float(np.sum((torque - columns / lengths @ best) ** 2))
    assert found.fit.squares + shop.unseen.left(found).sum() == pytest.approx(left, rel=1e-6)
    # It foretells that motion at once better than as it was, and worse than a fit to it alone.
    as_it_was = np.sum(shop.unseen.errors(found) ** 2)
    moved, price = shop.unseen.given_way(found)
    assert np.sum(shop.unseen.errors(moved) ** 2) + price.sum() < as_it_was
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
