"""How strongly to pull towards the reference: what predicts held-out torque best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.feasible.data_factor import DataFactor
from oed.estimation.feasible.interior import SolverFailed
from oed.estimation.feasible.problem import FeasibleProblem
from oed.estimation.feasible.solve import SolverName, solve_problem

FOLDS = 5
WEIGHTS = tuple(float(w) for w in np.logspace(-7, 0, 8))


@dataclass(frozen=True)
class WeightCurve:
    """Held-out error against the weight of the pull.

    Attributes:
        weights: (w,) tried.
        held_out: (w, folds) mean squared weighted residual of each fold; NaN where no
            solver came to a solution.
        fitted: (w, folds) the same of the data that were fitted.
        least_squares: (folds,) held-out error of least squares without demands, of least norm.
        best: Index of the weight with the least mean held-out error.
        chosen: Index of the largest weight whose held-out error exceeds that by no more than
            one standard error of the difference, over folds (Breiman and others 1984,
            section 3.4.3): what the data cannot tell apart, the reference decides.
    """

    weights: Float[ndarray, " w"]
    held_out: Float[ndarray, "w folds"]
    fitted: Float[ndarray, "w folds"]
    least_squares: Float[ndarray, " folds"]
    best: int
    chosen: int

    @property
    def weight(self) -> float:
        """The chosen weight."""
        return float(self.weights[self.chosen])

    @property
    def mean(self) -> Float[ndarray, " w"]:
        """Held-out error, mean over folds."""
        return self.held_out.mean(axis=1)


def cross_validate(
    problem: FeasibleProblem,
    blocks: Sequence[DataFactor],
    *,
    weights: Sequence[float] = WEIGHTS,
    folds: int = FOLDS,
    solvers: tuple[SolverName, ...] = ("clarabel", "barrier"),
) -> WeightCurve:
    """Leave out consecutive blocks, fold by fold, and predict them.

    Consecutive ones, because neighbours resemble each other: scattered blocks would ask for
    interpolation only.

    Args:
        problem: Its demands and reference are kept.
        blocks: Factors of consecutive pieces of data.
        weights: To try.
        folds: Number of parts; no more than there are blocks.
        solvers: To try, in this order.

    Raises:
        ValueError: If there are fewer than two blocks or folds.
        SolverFailed: If no weight could be solved for in all folds.
    """
    folds = min(folds, len(blocks))
    if folds < 2:
        raise ValueError(f"{len(blocks)} blocks cannot be left out in {folds} folds")
    held_out, fitted = np.full((2, len(weights), folds), np.nan)
    least_squares = np.empty(folds)
    for fold, left_out in enumerate(np.array_split(np.arange(len(blocks)), folds)):
        kept = [b for k, b in enumerate(blocks) if k not in left_out]
        training = DataFactor.join(kept)
        held = DataFactor.join([blocks[k] for k in left_out])
        here = problem.with_data(training)
        free = np.linalg.lstsq(here.factor, here.target, rcond=1e-10)[0]
        least_squares[fold] = held.misfit(problem.coordinates.parameters(free))
        for w, weight in enumerate(weights):
            try:
                x = solve_problem(here.with_weight(weight), solvers).x
            except SolverFailed:
                continue
            held_out[w, fold] = held.misfit(problem.coordinates.parameters(x))
            fitted[w, fold] = here.misfit(x)
    means = held_out.mean(axis=1)
    if np.isnan(means).all():
        raise SolverFailed("no weight could be tried in all folds", ())
    best = int(np.nanargmin(means))
    return WeightCurve(
        weights=np.array(weights),
        held_out=held_out,
        fitted=fitted,
        least_squares=least_squares,
        best=best,
        chosen=_largest_as_good(np.array(weights), held_out, best),
    )


def _largest_as_good(
    weights: Float[ndarray, " w"], held_out: Float[ndarray, "w folds"], best: int
) -> int:
    excess = held_out - held_out[best]
    error = excess.std(axis=1, ddof=1) / np.sqrt(held_out.shape[1])
    good = np.flatnonzero(excess.mean(axis=1) <= error)
    return int(good[np.argmax(weights[good])])
