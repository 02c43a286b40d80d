"""The band of torques of sampled models holds the torque of the arm as often as it says.

Arms are drawn from what is known before, by rejection, and each is recorded with noise. Then the
truth and the samples are draws from one distribution, given the recording, and the truth has any
rank among them with one probability (Cook, Gelman and Rubin 2006, J. Comp. Graph. Stat. 15(3)): of
39 samples least and largest hold 38 of 40.
"""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.motion import random_motion
from oed.export.samples import FeasibleRegion, draw_models
from oed.robot.inertia import pseudo_inertia
from tests.export.every_effect import model_with

ARMS, DRAWS = 60, 39
SPREAD = 0.3  # of parameters, of their size: a third of such bodies and more cannot be
NOISE = 2.0  # [N m]
INSTANTS = 10  # that are recorded: as many rows as parameters, so that edges still matter


def is_possible(region, parameters):
    bodies = parameters[: 10 * region.joints].reshape(-1, 10)
    has_bodies = all(np.linalg.eigvalsh(pseudo_inertia(body))[0] > 0 for body in bodies)
    return has_bodies and bool((region.weights @ parameters >= region.bounds).all())


def recorded(model, std, region, rng):
    """An arm that can be, and the model that a recording of it leaves; None where that cannot be."""
    truth = model.parameters + std * rng.normal(size=len(std))
    if not is_possible(region, truth):
        return None
    rows = model.torque_model.regressor(random_motion(model.robot, INSTANTS, rng))
    torque = rows @ truth + NOISE * rng.normal(size=len(rows))
    used = std > 0
    information = np.diag(1 / std[used] ** 2) + rows[:, used].T @ rows[:, used] / NOISE**2
    covariance, estimate = np.zeros((len(std),) * 2), model.parameters.copy()
    covariance[np.ix_(used, used)] = np.linalg.inv(information)
    estimate += covariance @ rows.T @ (torque - rows @ model.parameters) / NOISE**2
    found = dataclasses.replace(model, parameters=estimate, covariance=covariance, estimated=used)
    return (truth, found) if is_possible(region, estimate) else None


@pytest.fixture(scope="module")
def held():
    """Shares of held-out rows in the band: without noise, with it, and with it only in the rows."""
    model, _ = model_with("stribeck", duration=0.2)
    std, region = SPREAD * np.abs(model.parameters), FeasibleRegion.of(model)
    rng = np.random.default_rng(11)
    shares, possible, tried = [], True, 0
    while len(shares) < ARMS:
        tried += 1
        case = recorded(model, std, region, rng)
        if case is None:
            continue
        truth, found = case
        drawn = draw_models(found, DRAWS, rng)
        possible = possible and all(is_possible(region, each) for each in drawn)
        rows = model.torque_model.regressor(random_motion(model.robot, 40, rng))
        band, quiet = rows @ drawn.T, rows @ truth
        measured = quiet + NOISE * rng.normal(size=len(quiet))
        noisy = band + NOISE * rng.normal(size=band.shape)
        pairs = ((quiet, band), (measured, noisy), (measured, band))
        shares.append([np.mean((y > x.min(axis=1)) & (y < x.max(axis=1))) for y, x in pairs])
    return np.mean(shares, axis=0), possible, ARMS / tried


def test_every_sample_is_possible_where_many_arms_are_not(held):
    _, possible, accepted = held
    assert possible
    assert accepted < 0.7


def test_the_band_of_samples_holds_the_torque_without_noise(held):
    assert 0.93 < held[0][0] < 0.97


def test_a_measured_torque_is_in_the_band_only_with_noise_in_the_samples_too(held):
    _, with_noise, without = held[0]
    assert 0.93 < with_noise < 0.97
    assert without < 0.9
