"""What uncertain directions hide of white rows, against noise and friction that are drawn."""

import numpy as np
import pytest

from oed.estimation.noise_floor import uncertain_sign as module
from oed.estimation.noise_floor.autoregression import Autoregression
from oed.estimation.noise_floor.uncertain_sign import uncertain_in
from oed.experiment.preparation.direction import uncertain_direction
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import data_set

COULOMB = 2.0  # [N m]
BLUE = Autoregression(np.array([1.0, 1.5, 0.75]), 0.01)  # a resonance near half the row rate
DRAWS = 400


@pytest.fixture(scope="module")
def single():
    """A motion that is run once."""
    dataset = data_set(3, repetitions=1, roles=("estimation",))
    (prepared,) = prepare(dataset.recordings)
    return prepared


def test_rows_are_white_whatever_friction_does_where_it_is_uncertain(single):
    uncertain, whole = uncertain_in(single, 0, BLUE, COULOMB)
    doubtful = uncertain_direction(single, 0)
    assert 0 < doubtful.mean() < 0.2
    rng = np.random.default_rng(0)
    noise = rng.standard_normal((single.rows + 100, DRAWS)) * BLUE.scale
    for k in range(2, len(noise)):
        noise[k] -= BLUE.coefficients[1:] @ noise[[k - 1, k - 2]]
    # Friction of either sign, alike from where a joint turns to where it has turned.
    edges = np.flatnonzero(np.diff(doubtful, prepend=False, append=False))
    friction = np.zeros((len(doubtful), DRAWS))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        friction[start:end] = rng.uniform(-COULOMB, COULOMB, DRAWS)
    clean = BLUE.whiten(noise[100:]) * whole[:, None]
    white = BLUE.whiten(noise[100:] + single.band.apply(friction)) * whole[:, None]
    left = uncertain.out_of(white)
    assert np.mean(white**2) > 3 * np.mean(clean**2)
    # No row errs by more than noise, and those far from any turn by no less.
    assert np.mean(left**2, axis=1).max() < 1.5
    (part,) = uncertain.parts
    far = np.abs(part.directions).max(axis=1) < 1e-4
    assert far.sum() > 10
    assert left[far] == pytest.approx(clean[far], abs=0.05)


def test_rows_that_count_less_are_those_that_are_lost(single):
    uncertain, whole = uncertain_in(single, 0, BLUE, COULOMB)
    rng = np.random.default_rng(1)
    white = rng.standard_normal((single.rows, DRAWS)) * whole[:, None]
    kept = np.mean(np.sum(uncertain.out_of(white) ** 2, axis=0))
    assert whole.sum() - uncertain.count == pytest.approx(kept, rel=0.02)


def test_a_recording_in_parts_tells_as_much_as_in_one(single, monkeypatch):
    whole, _ = uncertain_in(single, 0, BLUE, COULOMB)
    monkeypatch.setattr(module, "AT_ONCE", 40)
    parted, _ = uncertain_in(single, 0, BLUE, COULOMB)
    assert len(parted.parts) > 2
    # A turn that lies across two parts costs both.
    assert parted.count == pytest.approx(whole.count, rel=0.1)
    white = np.random.default_rng(2).standard_normal((single.rows, DRAWS))
    inside = slice(45, 75)  # of one part, away from its ends
    off = parted.out_of(white)[inside] - whole.out_of(white)[inside]
    assert np.mean(off**2) < 0.05


def test_without_friction_nothing_is_uncertain(single):
    uncertain, _ = uncertain_in(single, 0, BLUE, 0.0)
    assert uncertain.count == 0.0
    white = np.ones((single.rows, 1))
    assert uncertain.out_of(white) == pytest.approx(white)
