"""Whether a body could have the inertial parameters of a load."""

from __future__ import annotations

import warnings

import cvxpy as cp
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.terms.trials import Trial
from oed.dynamics.effects.entries.payload import visible_load
from oed.dynamics.effects.payload import PayloadChange
from oed.robot.inertia import parameters_from_pseudo_inertia

# Share of what a load explains that bodies may fail to: true loads lose less than a hundredth,
# though other effects bias them, and noise a fifth or more.
LOST = 0.05


def is_no_body(
    trial: Trial,
    coefficients: Float[ndarray, " columns"],
    covariance: Float[ndarray, "columns columns"],
) -> bool:
    """Whether an addition is a load that no body can be, be it taken up or put down.

    Args:
        trial: Any addition.
        coefficients: Of its columns.
        covariance: Of these.
    """
    if not isinstance(trial.effect, PayloadChange):
        return False
    shown = visible_load(trial.effect.robot, trial.effect.link).regrouping
    return lost_by_bodies(shown, coefficients, covariance) > LOST


def lost_by_bodies(
    regrouping: Float[ndarray, "columns 10"],
    values: Float[ndarray, " columns"],
    covariance: Float[ndarray, "columns columns"],
) -> float:
    """Share of the squares that a load explains, which no body of one sign of mass explains.

    A load's pseudo-inertia is positive semidefinite if it is taken up, negative if it is put
    down (Wensing, Kim, Slotine 2018).

    Args:
        regrouping: What each estimated parameter stands for, of a body's ten.
        values: Their estimates.
        covariance: Of the estimates.

    Returns:
        From 0, where a body has these parameters, to 1, where the best is no body at all.
    """
    scale = np.sqrt(np.diag(covariance))
    # Where columns say nearly the same the covariance is singular but for rounding.
    information = np.linalg.pinv(covariance / np.outer(scale, scale), hermitian=True)
    squares, axes = np.linalg.eigh(information)
    root = axes * np.sqrt(np.maximum(squares, 0.0))
    units = np.eye(16).reshape(16, 4, 4)
    rows = np.array([parameters_from_pseudo_inertia(unit) for unit in units]).T
    white = root.T @ (regrouping @ rows / scale[:, None])
    target = root.T @ (values / scale)
    left = []
    for sign in (1.0, -1.0):
        body = cp.Variable((4, 4), PSD=True)
        error = sign * white @ cp.vec(body, order="C") - target
        with warnings.catch_warnings():
            # Where a load is hardly seen the answer has few digits, and that is enough.
            warnings.filterwarnings("ignore", message="Solution may be inaccurate")
            left.append(cp.Problem(cp.Minimize(cp.sum_squares(error))).solve(solver="CLARABEL"))
    return min(left) / float(target @ target)
