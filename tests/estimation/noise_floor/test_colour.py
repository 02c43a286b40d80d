"""The loudness of noise is what it was before a fit took its share, as far as what is left tells."""

import numpy as np
import pytest

from oed.estimation.noise_floor.colour import Colour, Stretches, noise_along, power_of_noise
from tests.diagnosis.noise import coloured

STARTS = (0, 700, 1500)
SEEN = np.arange(STARTS[-1]) % 10 > 0  # a tenth of the rows tells nothing
POLE = 0.8


def waves(end):
    """Orthonormal columns that hold all that is slower than `end` cycles a row, in each stretch."""
    blocks = []
    for k in (0, 1):
        rows = STARTS[k + 1] - STARTS[k]
        phase = np.pi * (np.arange(rows) + 0.5)[:, None] / rows
        block = np.zeros((STARTS[-1], round(2 * end * rows)))
        block[STARTS[k] : STARTS[k + 1]] = np.cos(phase * np.arange(block.shape[1]))
        blocks.append(block)
    return np.linalg.qr(np.concatenate(blocks, axis=1)[SEEN])[0]


def colour_of(noise, basis):
    stretches = Stretches(STARTS, SEEN)
    residual = noise[SEEN] - basis @ (basis.T @ noise[SEEN])
    return Colour.of(residual, stretches.taken_by(basis), stretches), residual


@pytest.mark.parametrize("end", [0.01, 0.03, 0.1])
def test_white_noise_is_as_loud_as_it_was(end):
    rng = np.random.default_rng(1)
    found = [colour_of(rng.normal(size=STARTS[-1]), waves(end))[0] for _ in range(40)]
    # Of 40 times 1,350 rows a mean square errs by 0.6 %; what columns take is known to as much.
    assert np.mean([c.mean_square for c in found]) == pytest.approx(1.0, abs=0.03)
    # At most an octave's mean square errs by a tenth for 200 rows of it.
    assert np.mean([c.correlated_rows for c in found]) == pytest.approx(1.0, abs=0.3)


def test_slow_noise_is_read_nearer_to_what_it_was_than_by_the_degrees_of_freedom():
    """All that is slower than a 33rd cycle a row is gone, which is nearly half of its squares."""
    rng, basis = np.random.default_rng(2), waves(0.03)
    squares, left = [], []
    for _ in range(20):
        colour, residual = colour_of(coloured(rng, STARTS[-1], POLE)[:, 0], basis)
        squares.append(colour.mean_square)
        left.append(float(residual @ residual) / (len(residual) - basis.shape[1]))
    assert np.mean(left) < 0.65
    # As loud below as in the slowest octave that tells, of which a first-order noise is louder.
    assert np.mean(left) + 0.15 < np.mean(squares) <= 1.0


@pytest.mark.parametrize(("slowest", "fastest"), [(0.1, 0.24), (0.0, 0.49)])
def test_an_octave_that_is_all_taken_is_as_loud_as_others(slowest, fastest):
    """Between others that tell; and where none does, with a fiftieth of the noise left in all."""
    rng, every = np.random.default_rng(4), waves(fastest)
    wide = every[:, round(2 * slowest * STARTS[1]) :] if slowest else every
    basis = wide[:, : int(0.98 * SEEN.sum())]
    found = [colour_of(rng.normal(size=STARTS[-1]), basis)[0].mean_square for _ in range(40)]
    assert np.mean(found) == pytest.approx(1.0, abs=0.15)


def test_rows_that_count_as_one_are_those_of_a_first_order_noise():
    rng, none = np.random.default_rng(3), np.zeros((int(SEEN.sum()), 0))
    found = [colour_of(coloured(rng, STARTS[-1], POLE)[:, 0], none)[0] for _ in range(20)]
    # The rows that tell nothing cost the autocorrelation a tenth; octaves are coarse.
    expected = (1 + POLE) / (1 - POLE)
    assert np.mean([c.correlated_rows for c in found]) == pytest.approx(expected, rel=0.25)


def test_columns_of_slow_waves_hold_more_of_slow_noise_than_of_white():
    basis, stretches = waves(0.03), Stretches(STARTS, SEEN)
    loud = np.array([8.0, 8, 8, 8, 4, 2, 1, 0.5, 0.1])
    power = np.stack([np.ones(9), loud], axis=1)  # white noise, and slow
    taken = [np.stack([own, own], axis=1) for own in stretches.taken_by(basis)]
    white, slow = noise_along(power, taken, stretches)
    assert white == pytest.approx(basis.shape[1])
    # An octave ends at 2^-5 of a cycle: the columns lie in those where noise is 4 to 8 times as loud.
    assert 4 < slow / white < 8


def test_the_colours_of_fits_side_by_side_are_those_of_each():
    rng, bases, stretches = (
        np.random.default_rng(5),
        [waves(0.01), waves(0.1)],
        Stretches(STARTS, SEEN),
    )
    noise = rng.normal(size=int(SEEN.sum()))
    residuals = np.stack([noise - b @ (b.T @ noise) for b in bases], axis=1)
    taken = [np.stack(own, axis=1) for own in zip(*map(stretches.taken_by, bases), strict=True)]
    together = power_of_noise(residuals, taken, stretches)
    for k, basis in enumerate(bases):
        alone = Colour.of(residuals[:, k], stretches.taken_by(basis), stretches)
        assert together[:, k] == pytest.approx(alone.power, rel=1e-12)
