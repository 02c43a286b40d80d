"""How strongly to pull towards the reference: what predicts held-out torque best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.feasible.data_factor import JointFactors
from oed.estimation.feasible.interior import SolverFailed
from oed.estimation.feasible.problem import FeasibleProblem
from oed.estimation.feasible.reweighting import log_rms, solve_reweighted
from oed.estimation.feasible.solve import SolverName
from oed.progress import tell

FOLDS = 5
WEIGHTS = tuple(float(w) for w in np.logspace(-7, 2, 10))
# Rise of the held-out rms residual that is not worth a weaker pull. A curve may be flat over many
# decades, with paired differences that are tiny and yet significant. One per cent of an rms, two of
# its square, is what choosing "the simplest model within 1.5 per cent of the best" asks (Kuhn 2008,
# "Building predictive models in R using the caret package", J. Stat. Software 28(5), `tolerance`).
TOLERANCE = 0.01


@dataclass(frozen=True)
class WeightCurve:
    """Held-out error against the weight of the pull.

    An error is the geometric mean over joints of the rms residual, in units of that of plain
    least squares on all data: `log_rms` says why.

    Attributes:
        weights: (w,) tried.
        held_out: (w, folds) error of each fold; NaN where no solver came to a solution.
        fitted: (w, folds) the same of the data that were fitted.
        least_squares: (folds,) held-out error of least squares without demands, of least norm.
        best: Index of the weight with the least held-out error, geometric mean over folds.
        chosen: Index of the largest weight whose log error exceeds that by no more than one
            standard error of the difference, over folds (Breiman and others 1984, section
            3.4.3), or by `TOLERANCE`: what the data cannot tell apart, or hardly care
            for, the reference decides.
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
        """Held-out error, geometric mean over folds."""
        return np.exp(np.log(self.held_out).mean(axis=1))

    @property
    def unsolved(self) -> tuple[float, ...]:
        """Weights that some fold came to no solution with; they were passed over."""
        return tuple(self.weights[np.isnan(self.held_out).any(axis=1)].tolist())


def cross_validate(
    problem: FeasibleProblem,
    blocks: Sequence[JointFactors],
    variances: Float[ndarray, " joints"],
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
        variances: (n,) torque variances of plain least squares [N^2 m^2].
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
        training = JointFactors.join([b for k, b in enumerate(blocks) if k not in left_out])
        held = JointFactors.join([blocks[k] for k in left_out])
        here = problem.with_data(training.weighted(variances))
        free = np.linalg.lstsq(here.factor, here.target, rcond=1e-10)[0]
        least_squares[fold] = log_rms(held, problem.coordinates.parameters(free), variances)
        for w, weight in enumerate(weights):
            tell("weight, by cross-validation", fold * len(weights) + w, folds * len(weights))
            try:
                fit = solve_reweighted(
                    here.with_weight(weight), training, variances, solvers=solvers
                )
            except SolverFailed:
                continue
            held_out[w, fold] = log_rms(held, fit.parameters, variances)
            fitted[w, fold] = log_rms(training, fit.parameters, variances)
    tell("weight, by cross-validation", held_out.size, held_out.size)
    if np.isnan(held_out.mean(axis=1)).all():
        raise SolverFailed("no weight could be tried in all folds", ())
    best, chosen = choose_weight(np.array(weights), held_out)
    return WeightCurve(
        weights=np.array(weights),
        held_out=np.exp(held_out),
        fitted=np.exp(fitted),
        least_squares=np.exp(least_squares),
        best=best,
        chosen=chosen,
    )


def choose_weight(
    weights: Float[ndarray, " w"], log_errors: Float[ndarray, "w folds"]
) -> tuple[int, int]:
    """The best weight by its mean log error, and the largest that is as good.

    Args:
        weights: Tried.
        log_errors: Logarithm of the held-out error; NaN where there is none.
    """
    best = int(np.nanargmin(log_errors.mean(axis=1)))
    excess = log_errors - log_errors[best]
    error = excess.std(axis=1, ddof=1) / np.sqrt(log_errors.shape[1])
    good = np.flatnonzero(excess.mean(axis=1) <= np.maximum(error, np.log1p(TOLERANCE)))
    return best, int(good[np.argmax(weights[good])])
