"""Models that the data do not tell apart: draws from the estimate's covariance, every body possible.

What is drawn is the normal distribution of the estimate, cut off where no body has such an inertia
or an effect would be of the wrong sign. Hit-and-run (Smith 1984, Operations Research 32(6)) walks in
it: a direction of the covariance at random, the stretch of that line that is feasible, and a point
of the normal distribution on it. The chain leaves exactly that distribution as it is: nothing is
projected, and so nothing is drawn to an edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.special import ndtr, ndtri

from oed.errors import NoUsableResult
from oed.export.bodies import calibrated_robot
from oed.export.model import Model
from oed.robot.inertia import pseudo_inertia

RANK = 1e-12  # of the covariance's largest eigenvalue, in units of the deviations
STEPS = 5  # of the walk a dimension, from one draw to the next: enough to forget where it was
MARGIN = 1e-6  # of a body's pseudo-inertia that is kept in every direction
FARTHEST = 8.0  # standard deviations: beyond that the normal distribution is rounding


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
        self, point: Float[ndarray, " p"], way: Float[ndarray, " p"]
    ) -> tuple[float, float]:
        """Least and largest multiple of `way` from a possible point that stays possible."""
        least, most = -np.inf, np.inf
        slack, rate = self.weights @ point - self.bounds, self.weights @ way
        with np.errstate(divide="ignore"):
            ends = -slack / rate
        least = max(least, float(ends[rate > 0].max(initial=-np.inf)))
        most = min(most, float(ends[rate < 0].min(initial=np.inf)))
        for i in range(self.joints):
            own = slice(10 * i, 10 * i + 10)
            # J + s D is positive definite while 1 + s e is positive for all e of L^-1 D L^-T.
            root = np.linalg.inv(np.linalg.cholesky(pseudo_inertia(point[own])))
            turned = np.linalg.eigvalsh(root @ pseudo_inertia(way[own]) @ root.T)
            inside = 1 - MARGIN
            least = max(least, -inside / turned[-1] if turned[-1] > 0 else -np.inf)
            most = min(most, -inside / turned[0] if turned[0] < 0 else np.inf)
        return least, most


def draw_models(model: Model, count: int, rng: np.random.Generator) -> Float[ndarray, "count p"]:
    """Parameters of models that the data do not tell from a model.

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
    region, z = FeasibleRegion.of(model), np.zeros(half.shape[1])
    drawn = np.empty((count, len(model.parameters)))
    for k in range(count):
        for _ in range(STEPS * len(z)):
            z = _stepped(z, half, model.parameters, region, rng)
        drawn[k] = model.parameters + half @ z
    return drawn


def half_covariance(covariance: Float[ndarray, "p p"]) -> Float[ndarray, "p rank"]:
    """A with A A' = covariance, by the correlations, whose entries are of one size."""
    std = np.sqrt(np.diag(covariance))
    scaled = covariance / np.outer(std, std).clip(min=np.finfo(float).tiny)
    values, vectors = np.linalg.eigh(scaled)
    kept = values > RANK * values[-1]
    return std[:, None] * vectors[:, kept] * np.sqrt(values[kept])


def _stepped(
    z: Float[ndarray, " rank"],
    half: Float[ndarray, "p rank"],
    centre: Float[ndarray, " p"],
    region: FeasibleRegion,
    rng: np.random.Generator,
) -> Float[ndarray, " rank"]:
    """One step of hit-and-run in units of standard deviations."""
    way = rng.normal(size=len(z))
    way /= np.linalg.norm(way)
    least, most = region.stretch(centre + half @ z, half @ way)
    # Along the line the normal distribution is one of unit width about -z . way.
    middle = -float(z @ way)
    low, high = (float(np.clip(x - middle, -FARTHEST, FARTHEST)) for x in (least, most))
    share = ndtr(low) + rng.uniform() * (ndtr(high) - ndtr(low))
    return z + (middle + float(ndtri(share))) * way
