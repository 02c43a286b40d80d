"""Stretches of long recordings are those recordings' own rows, spread over all of them."""

import numpy as np

from oed.experiment.preparation.excerpts import STRETCHES, excerpts
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import data_set, once

PREPARED = prepare([once(r) for r in data_set(3, step=1e-7).recordings])
TOTAL = sum(p.rows for p in PREPARED)


def test_few_rows_are_all_looked_at():
    assert excerpts(PREPARED, TOTAL) == PREPARED


def test_rows_of_a_stretch_are_those_of_its_recording():
    few = excerpts(PREPARED, TOTAL // 3)
    assert 0 < sum(p.rows for p in few) <= TOTAL // 3
    for part in few:
        whole = next(p for p in PREPARED if p.name == part.name)
        where = np.searchsorted(whole.t, part.t)
        assert np.array_equal(whole.t[where], part.t)
        assert np.array_equal(whole.torque[where], part.torque)
        # The filter finds the same rows in the fine samples that it was given.
        assert np.allclose(part.band.apply(part.fine_torque), part.torque, atol=1e-12)
        assert np.array_equal(part.valid, whole.valid[where])
        assert len(part.motion) == len(part.fine_torque) == len(part.recorded)


def test_stretches_lie_from_begin_to_end():
    longest = max(PREPARED, key=lambda p: p.rows)
    few = excerpts([longest], longest.rows // 4)
    assert len(few) >= STRETCHES - 1
    middle = [float(np.mean(p.t)) for p in few]
    assert min(middle) < longest.t[0] + 0.25 * np.ptp(longest.t)
    assert max(middle) > longest.t[-1] - 0.25 * np.ptp(longest.t)
    assert np.ptp(np.diff(middle)) < 0.1 * np.ptp(longest.t)


def test_repeated_motions_stay_whole():
    repeated = prepare(data_set(3, step=1e-7, repetitions=3).recordings)
    assert excerpts(repeated, 10) == repeated
