"""All gains, the arm and its loads at once, by damped steps of Gauss and Newton."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import block_diag

from oed.errors import NoUsableResult
from oed.estimation.covariance import estimate_covariance
from oed.estimation.feasible.data_factor import JointFactors
from oed.estimation.load.current_equations import CurrentEquations
from oed.estimation.load.friction_change import friction_change
from oed.estimation.load.known_arm import HEAVIEST, LOAD_FRICTION, WIDE
from oed.estimation.noise import whiten
from oed.estimation.prior import Prior
from oed.estimation.triangular import add_prior, solve

STEPS = 60
SETTLED = 0.01  # of a standard deviation
HALVINGS = 12
EXPLAINED = 0.5  # correlation from which the file's torque tells a joint's gain
# Of log u about its start: a gain that nothing tells stays open by a factor of twenty.
OPEN_GAIN = 3.0
PINNED = 1e-4  # of the log u that is the unit of the others where no mass is known


@dataclass(frozen=True)
class GainFit:
    """An estimate of x of `CurrentEquations`.

    Attributes:
        x: (x,).
        covariance: (x, x).
        degrees_of_freedom: (x,) of each one's Student-t interval.
        residual: (N, n) measured less modelled current [A].
        variances: (n,) of the residuals [A^2].
    """

    x: Float[ndarray, " x"]
    covariance: Float[ndarray, "x x"]
    degrees_of_freedom: Float[ndarray, " x"]
    residual: Float[ndarray, "samples joints"]
    variances: Float[ndarray, " joints"]


def fit_gains(equations: CurrentEquations) -> GainFit:
    """Estimate gains, arm and loads from currents.

    Raises:
        NoUsableResult: If no gains come near to explaining them, and so the search does not settle.
    """
    at = _start(equations)
    start = at[equations.places["log_u"]].copy()
    variances = np.mean(equations.current**2, axis=0)
    before, (at, variances, factor) = at, _step(equations, at, start, variances)
    for _ in range(STEPS - 1):
        if np.all(np.abs(factor @ (at - before)) <= SETTLED):
            break
        before, (at, variances, factor) = at, _step(equations, at, start, variances)
    else:
        raise NoUsableResult(
            f"no gains are found in {STEPS} steps: the currents do not differ between the data sets as "
            "the stated loads would make them; correct --mass and --com, or which folder holds which load"
        )
    rows, _ = equations.linearised(at)
    residual = equations.current - equations.modelled(at)
    joints = residual.shape[1]
    spread = estimate_covariance(
        whiten(rows, variances, joints),
        whiten(residual.reshape(-1), variances, joints).reshape(-1, joints),
        factor,
        segments=equations.segments,
    )
    return GainFit(at, spread.covariance, spread.degrees_of_freedom, residual, variances)


def _step(
    equations: CurrentEquations,
    at: Float[ndarray, " x"],
    start: Float[ndarray, " gains"],
    variances: Float[ndarray, " joints"],
) -> tuple[Float[ndarray, " x"], Float[ndarray, " joints"], Float[ndarray, "x x"]]:
    """The next x, the variances that it was found with, and the factor of its information."""
    rows, right = equations.linearised(at)
    residual = equations.current - equations.modelled(at)
    variances = np.minimum(variances, np.mean(residual**2, axis=0))
    prior = _prior(equations, rows, at, start)
    target, factor = _solve(rows, right, variances, prior)
    return _descended(equations, at, target, variances, prior), variances, factor


def _start(equations: CurrentEquations) -> Float[ndarray, " x"]:
    """The robot file's arm with nothing held, and the gains by which it explains most of the currents.

    Friction is most of a small joint's current: each joint's is fitted beside. Joints that the file's arm
    does not explain begin with the typical gain of the others.
    """
    x = np.zeros(equations.size)
    model = equations.model
    full = np.zeros(model.base.regrouping.shape[1])
    inertial = 10 * equations.joints
    full[:inertial] = model.arm.robot.parameters
    x[equations.places["beta"]] = model.base.from_standard(full)
    torque, current = equations.modelled(x), equations.current
    rows, _ = equations.linearised(x)
    friction = rows[:, : len(model.base)].reshape(*current.shape, -1)[
        :, :, list(equations.friction)
    ]
    found = [_share(torque[:, j], friction[:, j], current[:, j]) for j in range(equations.joints)]
    told = [share for share in found if share > 0]
    sizes = [float(np.sqrt(np.mean(s**2))) for s in (current, torque)]
    typical = float(np.median(told)) if told else sizes[0] / max(sizes[1], np.finfo(float).tiny)
    x[equations.places["log_u"]] = np.log([share if share > 0 else typical for share in found])
    return x


def _share(
    torque: Float[ndarray, " samples"],
    friction: Float[ndarray, "samples columns"],
    current: Float[ndarray, " samples"],
) -> float:
    """Current per torque, friction and a constant apart; 0 where the torque does not explain it."""
    beside = np.column_stack([friction[:, np.any(friction != 0, axis=0)], np.ones(len(current))])
    pair = np.column_stack([torque, current])
    left = pair - beside @ np.linalg.lstsq(beside, pair, rcond=None)[0]
    squares = np.sum(left**2, axis=0)
    product = float(left[:, 0] @ left[:, 1])
    explains = product > EXPLAINED * np.sqrt(squares[0] * squares[1]) > 0
    return product / float(squares[0]) if explains else 0.0


def reference_joint(equations: CurrentEquations) -> int:
    """The joint whose gain is the unit of the others where no mass is known: the largest current."""
    return int(np.argmax(np.mean(equations.current**2, axis=0)))


def _prior(
    equations: CurrentEquations,
    rows: Float[ndarray, "rows x"],
    at: Float[ndarray, " x"],
    start: Float[ndarray, " joints"],
) -> Prior:
    """Wide, but for changes of friction and the share that gears lose."""
    places = equations.places
    mean, std = np.zeros(equations.size), np.full(equations.size, HEAVIEST)
    sizes = np.sqrt(np.mean(rows[:, places["beta"]] ** 2, axis=0))
    largest = float(np.sqrt(np.mean(equations.current**2, axis=0)).max())
    std[places["beta"]] = np.divide(
        WIDE * largest, sizes, out=np.full(len(sizes), HEAVIEST), where=sizes > 0
    )
    std[places["mu"]] = LOAD_FRICTION
    std[places["log_u"]], mean[places["log_u"]] = OPEN_GAIN, start
    if not equations.has_scale:
        std[places["log_u"].start + reference_joint(equations)] = PINNED
    covariance = np.diag(std**2)
    covariance[places["change"], places["change"]] = block_diag(*_changes(equations, at))
    return Prior.gaussian(mean, covariance)


def _changes(equations: CurrentEquations, at: Float[ndarray, " x"]) -> list[ndarray]:
    """Covariance of what friction differs by in each folder but the first."""
    own = np.ix_(equations.friction, equations.friction)
    beta = at[equations.places["beta"]]
    return [
        friction_change(other, np.append(beta, np.zeros(len(other.model.names) - len(beta))))[own]
        for other in equations.sets[1:]
    ]


def _solve(
    rows: Float[ndarray, "rows x"],
    right: Float[ndarray, "samples joints"],
    variances: Float[ndarray, " joints"],
    prior: Prior,
) -> tuple[Float[ndarray, " x"], Float[ndarray, "x x"]]:
    data = JointFactors.of(rows.reshape(*right.shape, -1), right)
    posterior = add_prior(data.weighted(variances).triangle, prior)
    return solve(posterior), posterior[:-1, :-1]


def _descended(
    equations: CurrentEquations,
    at: Float[ndarray, " x"],
    target: Float[ndarray, " x"],
    variances: Float[ndarray, " joints"],
    prior: Prior,
) -> Float[ndarray, " x"]:
    """As far towards a target as the objective falls, halving; where it is, if it does not."""

    def value(x: Float[ndarray, " x"]) -> float:
        data = np.sum((equations.current - equations.modelled(x)) ** 2 / variances)
        return float(data + np.sum((prior.factor @ (x - prior.mean)) ** 2))

    before, length = value(at), 1.0
    for _ in range(HALVINGS):
        tried = at + length * (target - at)
        if value(tried) < before:
            return tried
        length /= 2
    return at
