"""From stacked torque equations to an Estimate, with the defaults of this package."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.covariance import CovarianceMethod, estimate_covariance
from oed.estimation.estimate import Estimate
from oed.estimation.identifiability import (
    LARGEST_RELATIVE_STD,
    Identifiability,
    badly_excited,
    find_identifiable,
    hidden_errors,
)
from oed.estimation.least_squares import stacked
from oed.estimation.noise import whitened
from oed.estimation.prior import Prior
from oed.estimation.reach import Reach, find_reach
from oed.estimation.robust import RobustLoss, robust_least_squares
from oed.estimation.row_pieces import RowPieces
from oed.estimation.streaming import StreamingLeastSquares
from oed.estimation.triangular import NotIdentifiable, Solution

SMALLEST = 1e-12  # of a weight


@dataclass(frozen=True)
class _Fit:
    """A solution with the whitened rows and residuals that its covariance is read from."""

    solution: Solution
    white_regressor: RowPieces
    white_residual: Float[ndarray, "samples joints"]
    variances: Float[ndarray, " joints"]
    text: str


def identify(
    regressor: Float[ndarray, "rows p"] | RowPieces,
    torque: Float[ndarray, "samples joints"],
    names: tuple[str, ...],
    units: tuple[str, ...],
    *,
    noise: Float[ndarray, " joints"] | None = None,
    prior: Prior | None = None,
    robust: RobustLoss | None = None,
    covariance: CovarianceMethod = "hac",
    segments: tuple[int, ...] | None = None,
    largest_relative_std: float = LARGEST_RELATIVE_STD,
    others: Sequence[Float[ndarray, "_ p"] | RowPieces] = (),
    usual_torque: Float[ndarray, " joints"] | None = None,
    certainty: Float[ndarray, "samples joints"] | None = None,
) -> Estimate:
    """Estimate what the data determine, and name what they do not.

    Directions that the rows do not carry to other motions are left at zero, as `reach` says.

    Args:
        regressor: H, row k n + j is joint j at sample k; an array, or in pieces across which no
            residual is correlated.
        torque: (N, n) [N m].
        names: (p,) of the columns.
        units: (p,).
        noise: (n,) variances of the joints [N^2 m^2]; None takes them from the residuals.
        prior: None is R_xi = inf.
        robust: Loss of an M-estimate in place of least squares; it finds its own variances.
        covariance: As in `estimate_covariance`.
        segments: Samples of each recording in the stack, where it is an array.
        largest_relative_std: Beyond it a parameter is named and not quoted.
        others: Regressors of further motions that torque is to be foretold for.
        usual_torque: (n,) rms torque of each joint on all motions [N m]; of `torque` if None.
        certainty: (N, n) share of noise in the variance of each row, by which its square counts;
            one if None.

    Raises:
        ValueError: If shapes disagree, entries are not finite, `noise` comes with `robust`, or
            no degree of freedom is left.
        NotIdentifiable: If nothing is determined, or only some parameters are and a prior
            on the others cannot be carried over to the combinations.
    """
    joints = torque.shape[1]
    weights = np.ones_like(torque) if certainty is None else certainty
    root = np.sqrt(weights).reshape(-1)
    rows = torque.reshape(-1) * root
    measured = stacked(RowPieces.of(regressor, joints, segments), rows, joints)
    if robust and noise is not None:
        raise ValueError("a robust estimate finds its own noise: give either")
    weighted = measured.changed(lambda H, place: H * root[place, None], measured.columns)
    seen = StreamingLeastSquares.of(weighted, rows)
    found = _determined(seen.factor, names, prior)
    kept = list(found.kept)
    columns, seen = weighted.only(kept), seen.of_columns(kept)

    def fitted(prior: Prior | None) -> _Fit:
        if robust:
            return _fit_robust(columns, rows, joints, prior, robust)
        return _fit_least_squares(columns, rows, seen, prior, noise)

    def variances_of(fit: _Fit) -> Float[ndarray, " joints"]:
        # Of a row that is certain: others have less than all of it in their squares.
        return fit.variances / np.maximum(weights.mean(axis=0), SMALLEST)

    whole = fitted(prior)
    usual = np.sqrt(np.mean(torque**2, axis=0)) if usual_torque is None else usual_torque
    # With a prior on them no direction is left to the data alone.
    reach = (
        Reach.none(len(kept))
        if prior is not None and len(prior.factor)
        else find_reach(
            columns,
            [RowPieces.of(h, joints).only(kept) for h in others],
            np.sqrt(variances_of(whole)),
            usual,
        )
    )
    # A joint may fit worse for what is held at zero: then its weight is another.
    fit = fitted(reach.prior(torque.size)) if reach.lost else whole
    parameters = fit.solution.parameters
    spread = estimate_covariance(
        fit.white_regressor,
        fit.white_residual,
        fit.solution.posterior_factor,
        method=covariance,
    )
    weak = {
        **badly_excited(
            found.names,
            parameters,
            spread.covariance,
            whole.solution.information_factor,
            threshold=largest_relative_std,
        ),
        **hidden_errors(found.names, parameters, reach.spread, threshold=largest_relative_std),
    }
    return Estimate(
        names=found.names,
        units=tuple(units[c] for c in found.kept),
        parameters=parameters,
        covariance=spread.covariance,
        information_factor=whole.solution.information_factor,
        residual=torque - measured.only(kept).predict(parameters),
        degrees_of_freedom=float(max(weights.sum() - len(parameters), 1.0)),
        effective_degrees_of_freedom=spread.degrees_of_freedom,
        joint_variances=variances_of(fit),
        status="reduced" if found.removed or reach.lost else "determined",
        method=f"{fit.text}; covariance: {spread.text}",
        unidentifiable=found.removed + tuple(weak),
        reasons=found.reasons + tuple(weak.values()),
        columns=found.kept,
        reach=reach.factor,
        quoted_from=1 / largest_relative_std,
    )


def _determined(
    factor: Float[ndarray, "p p"], names: tuple[str, ...], prior: Prior | None
) -> Identifiability:
    rows = factor if prior is None else np.vstack([factor, prior.factor])
    found = find_identifiable(rows, names)
    lost = found.removed and prior is not None and len(prior.factor)
    if lost or not found.kept:
        raise NotIdentifiable(
            f"not determined by the data and the prior: {', '.join(found.removed)}",
            found.singular_values,
            np.zeros(len(names)),
        )
    return found


def _fit_least_squares(
    regressor: RowPieces,
    torque: Float[ndarray, " rows"],
    seen: StreamingLeastSquares,
    prior: Prior | None,
    noise: Float[ndarray, " joints"] | None,
) -> _Fit:
    if noise is None:
        solution, noise = seen.solve_with_residual_variances(prior)
        text = "least squares, joint variances from residuals"
    else:
        solution = seen.solve(noise, prior)
        text = "least squares, given noise"
    residual = torque.reshape(-1, regressor.joints) - regressor.predict(solution.parameters)
    return _Fit(
        solution=solution,
        white_regressor=whitened(regressor, noise),
        white_residual=residual / np.sqrt(noise),
        variances=np.mean(residual**2, axis=0),
        text=text,
    )


def _fit_robust(
    regressor: RowPieces,
    torque: Float[ndarray, " rows"],
    joints: int,
    prior: Prior | None,
    loss: RobustLoss,
) -> _Fit:
    robust = robust_least_squares(regressor, torque, joints, loss=loss, prior=prior)
    return _Fit(
        solution=robust.solution,
        white_regressor=robust.pseudo_regressor,
        white_residual=robust.pseudo_residual,
        variances=robust.variances,
        text=f"M-estimate with the {loss} loss, joint scales from the median absolute residual",
    )
