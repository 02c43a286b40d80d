"""Models that the data do not tell apart: draws from the estimate's covariance, every body possible.

What is drawn is the normal distribution of the estimate, cut off where no body has such an inertia
or an effect would be of the wrong sign. Hit-and-run (Smith 1984, Operations Research 32(6)) walks in
it: a direction of the covariance at random, the stretch of that line that is feasible, and a point
of the normal distribution on it. The walk leaves exactly that distribution as it is: nothing is
projected, and so nothing is drawn to an edge. Every draw is the end of a walk of its own from the
estimate, all walked at once, so that no draw depends on another.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.special import ndtr, ndtri

from oed.dynamics.motion import random_motion
from oed.errors import NoUsableResult
from oed.export.bodies import calibrated_robot
from oed.export.model import Model
from oed.robot.inertia import pseudo_inertia

RANK = 1e-12  # of the covariance's largest eigenvalue, in units of the deviations
STEPS = 10  # of a walk a dimension: what it remembers of its start is below e^-10
MARGIN = 1e-6  # of a body's pseudo-inertia that is kept in every direction
STATES = 100  # at which the torque's spread is looked at
FARTHEST = 8.0  # standard deviations: beyond that the normal distribution is rounding

UNITS = np.array([pseudo_inertia(unit) for unit in np.eye(10)])  # of each of the ten parameters


@dataclass(frozen=True)
class FeasibleRegion:
    """Where parameters are possible, along a line.

    Attributes:
        joints: Number of links n: the first ten parameters of each are its body's.
        weights: (k, p) what effects ask.
        bounds: (k,) weights @ parameters >= bounds.
    """

    joints: int
    weights: Float[ndarray, "k p"]
    bounds: Float[ndarray, " k"]

    @classmethod
    def of(cls, model: Model) -> FeasibleRegion:
        """Of a model's bodies and effects."""
        count, rows, bounds, start = len(model.parameters), [], [], 0
        for effect in model.torque_model.effects:
            for demand in effect.demands:
                row = np.zeros(count)
                row[start : start + len(demand.weights)] = demand.weights
                rows.append(row)
                bounds.append(demand.bound)
            start += len(effect.parameters)
        return cls(model.robot.n, np.array(rows).reshape(-1, count), np.array(bounds))

    def stretch(
        self, points: Float[ndarray, "count p"], ways: Float[ndarray, "count p"]
    ) -> tuple[Float[ndarray, " count"], Float[ndarray, " count"]]:
        """Least and largest multiple of each way from a possible point that stays possible."""
        slack, rate = points @ self.weights.T - self.bounds, ways @ self.weights.T
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = -slack / rate
        least = np.where(rate > 0, ends, -np.inf).max(axis=1, initial=-np.inf)
        most = np.where(rate < 0, ends, np.inf).min(axis=1, initial=np.inf)
        # J + s D is positive definite while 1 + s e is positive for all e of L^-1 D L^-T.
        inertias, turns = (self._pseudo_inertias(x) for x in (points, ways))
        roots = np.linalg.inv(np.linalg.cholesky(inertias))
        turned = np.linalg.eigvalsh(roots @ turns @ roots.swapaxes(-1, -2)).reshape(len(ways), -1)
        lowest, highest = turned.min(axis=1), turned.max(axis=1)
        inside = 1 - MARGIN
        with np.errstate(divide="ignore"):
            least = np.maximum(least, np.where(highest > 0, -inside / highest, -np.inf))
            most = np.minimum(most, np.where(lowest < 0, -inside / lowest, np.inf))
        return least, most

    def _pseudo_inertias(
        self, parameters: Float[ndarray, "count p"]
    ) -> Float[ndarray, "count joints 4 4"]:
        """Of all links: linear in their ten parameters each."""
        own = parameters[:, : 10 * self.joints].reshape(-1, self.joints, 10)
        return np.tensordot(own, UNITS, axes=1)


def draw_models(model: Model, count: int, rng: np.random.Generator) -> Float[ndarray, "count p"]:
    """Parameters of models that the data do not tell from a model.

    The torques that they foretell spread as the torque without noise is uncertain; a measured
    torque has its noise besides.

    Args:
        model: Of possible bodies, with its covariance.
        count: How many.
        rng: Of the draws.

    Raises:
        NoUsableResult: If the model has no covariance, or its bodies are not possible.
    """
    calibrated_robot(model)
    if model.covariance is None:
        raise NoUsableResult("the model has no covariance to draw from: oed feasible leaves one")
    half = half_covariance(model.covariance)
    region, z = FeasibleRegion.of(model), np.zeros((count, half.shape[1]))
    for _ in range(STEPS * half.shape[1]):
        z = _stepped(z, half, model.parameters, region, rng)
    return model.parameters + z @ half.T


def kept_spread(model: Model, drawn: Float[ndarray, "count p"], rng: np.random.Generator) -> float:
    """Spread of the draws' torque over that of the covariance, the median of random states.

    The covariance is one of estimates that are possible, and so is cut off already. Where most of a
    normal distribution with it is impossible, the second cut leaves less.

    Args:
        model: That was drawn about, with its covariance.
        drawn: Of it.
        rng: Of the states.
    """
    arm = dataclasses.replace(model.torque_model, measurement=())
    rows = arm.regressor(random_motion(model.robot, STATES, rng))
    told = np.linalg.norm(rows @ half_covariance(model.covariance), axis=1)  # pyright: ignore[reportArgumentType]  # drawn about: it has one
    moves = told > 0
    return float(np.median(np.std(rows[moves] @ drawn.T, axis=1, ddof=1) / told[moves]))


def half_covariance(covariance: Float[ndarray, "p p"]) -> Float[ndarray, "p rank"]:
    """A with A A' = covariance, by the correlations, whose entries are of one size."""
    std = np.sqrt(np.diag(covariance))
    scaled = covariance / np.outer(std, std).clip(min=np.finfo(float).tiny)
    values, vectors = np.linalg.eigh(scaled)
    kept = values > RANK * values[-1]
    return std[:, None] * vectors[:, kept] * np.sqrt(values[kept])


def _stepped(
    z: Float[ndarray, "count rank"],
    half: Float[ndarray, "p rank"],
    centre: Float[ndarray, " p"],
    region: FeasibleRegion,
    rng: np.random.Generator,
) -> Float[ndarray, "count rank"]:
    """One step of hit-and-run of every walk, in units of standard deviations."""
    ways = rng.normal(size=z.shape)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    least, most = region.stretch(centre + z @ half.T, ways @ half.T)
    # Along the line the normal distribution is one of unit width about -z . way.
    middle = -np.sum(z * ways, axis=1)
    low, high = (ndtr(np.clip(x - middle, -FARTHEST, FARTHEST)) for x in (least, most))
    share = low + rng.uniform(size=len(z)) * (high - low)
    return z + (middle + ndtri(share))[:, None] * ways
