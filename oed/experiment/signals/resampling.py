"""From the instants that were logged to a uniform grid."""

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray


def fresh_rows(
    *signals: Float[ndarray, " samples *columns"], longest: int = 20
) -> Bool[ndarray, " samples"]:
    """Which rows are not exact repeats of the row before.

    Where a state is read faster than it is updated, a row repeats all numbers of its
    predecessor although time went on; that is a stale row, and interpolation over it is
    closer to the truth. A longer run of equal rows is a robot that stands still without
    noise, and is kept whole.

    Args:
        signals: (N, ...) signals that were read together; a row is stale if all repeat.
        longest: Most rows in a row that may be stale.

    Returns:
        (N,) mask, true at the first sample.
    """
    samples = len(signals[0])
    repeats = np.ones(samples, dtype=bool)
    repeats[0] = False
    for signal in signals:
        flat = signal.reshape(samples, -1)
        repeats[1:] &= (flat[1:] == flat[:-1]).all(axis=1)
    edges = np.flatnonzero(np.diff(repeats, prepend=False, append=False))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        if end - start > longest:
            repeats[start:end] = False
    return ~repeats


def uniform_grid(t: Float[ndarray, " samples"], rate: float) -> Float[ndarray, " grid"]:
    """Instants t[0], t[0] + 1/rate, … up to t[-1] [s].

    Raises:
        ValueError: If the rate [Hz] is not positive.
    """
    if rate <= 0:
        raise ValueError(f"rate {rate:g} Hz must be positive")
    # Rounding must not lose the last instant of a grid that already is uniform.
    steps = int(np.floor((t[-1] - t[0]) * rate + 1e-6))
    return np.minimum(t[0] + np.arange(steps + 1) / rate, t[-1])


def resample(
    t: Float[ndarray, " samples"],
    x: Float[ndarray, " samples *columns"],
    grid: Float[ndarray, " grid"],
) -> Float[ndarray, " grid *columns"]:
    """Interpolate samples linearly at other instants.

    It loses up to (pi f h)^2 / 2 of an amplitude at frequency f for steps of h, and makes no noise larger.

    Args:
        t: (N,) increasing instants [s].
        x: (N, ...) samples.
        grid: (M,) instants within [t[0], t[-1]] [s].

    Raises:
        ValueError: If the grid leaves the recorded time or N is too small.
    """
    if grid[0] < t[0] or grid[-1] > t[-1]:
        raise ValueError(
            f"grid {grid[0]:g}..{grid[-1]:g} s leaves the recording {t[0]:g}..{t[-1]:g} s"
        )
    if len(t) < 4:
        raise ValueError(f"{len(t)} samples are too few to interpolate; at least 4")
    flat = x.reshape(len(x), -1)
    columns = [np.interp(grid, t, flat[:, j]) for j in range(flat.shape[1])]
    return np.stack(columns, axis=1).reshape(len(grid), *x.shape[1:])
