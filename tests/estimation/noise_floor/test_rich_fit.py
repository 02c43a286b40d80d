"""What may join a rich fit, held against projections that are written out."""

import numpy as np
import pytest

from oed.estimation.noise_floor.colour import Stretches
from oed.estimation.noise_floor.rich_fit import Additions

ROWS = 60
WIDTHS = (3, 5, 2)


@pytest.fixture
def blocks():
    rng = np.random.default_rng(7)
    return [rng.normal(size=(ROWS, width)) for width in WIDTHS]


@pytest.fixture
def span():
    return np.linalg.qr(np.random.default_rng(8).normal(size=(ROWS, 4)))[0]


def _projector(columns):
    return columns @ np.linalg.pinv(columns)


def test_bases_span_what_each_block_adds(blocks, span):
    found = Additions.of(blocks).outside(span)
    assert found.widths == WIDTHS
    for block, place in zip(blocks, found.places, strict=True):
        basis = found.columns[:, place]
        left = block - span @ (span.T @ block)
        np.testing.assert_allclose(basis @ basis.T, _projector(left), atol=1e-10)


def test_each_is_asked_about_its_own_columns(blocks, span):
    # The second lies inside the span and adds nothing: its neighbours' columns are not its own.
    inside = [blocks[0], span @ np.ones((4, 2)), blocks[2]]
    found = Additions.of(inside).outside(span)
    assert found.widths == (3, 0, 2)
    stretches = Stretches((0, 25, ROWS), np.ones(ROWS, dtype=bool))
    for k, block in enumerate(inside):
        projector = _projector(block - span @ (span.T @ block)) if k != 1 else np.zeros((ROWS,) * 2)
        for part, (a, b) in zip(found.taken(stretches), [(0, 25), (25, ROWS)], strict=True):
            spectrum = np.fft.fft(np.eye(b - a))[: len(part)]
            expected = np.real(np.diag(spectrum @ projector[a:b, a:b] @ spectrum.conj().T)) / (
                b - a
            )
            np.testing.assert_allclose(part[:, k], expected, atol=1e-10)
    assert found.without(1).widths == (3, 2)
    np.testing.assert_array_equal(found.without(0).columns, found.columns[:, 3:])


def test_the_block_that_explains_the_torque_convinces_most(blocks, span):
    rng = np.random.default_rng(9)
    torque = blocks[2] @ np.array([3.0, -2.0]) + 0.1 * rng.normal(size=ROWS)
    found = Additions.of(blocks).outside(span)
    stretches = Stretches((0, ROWS), np.ones(ROWS, dtype=bool))
    left = torque - span @ (span.T @ torque)
    taken = [squares.sum(axis=1) for squares in stretches.squares(span)]
    ratios = found.convincing(left, taken, found.taken(stretches), stretches)
    assert np.argmax(ratios) == 2
    assert ratios[2] > 100 * max(ratios[:2])
