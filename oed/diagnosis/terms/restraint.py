"""What of a free-form term the data determine: the rest is left out, so that it cannot run away.

A spline beside a rigid-body model has combinations of its functions that the model nearly
makes itself. Least squares gives them large values that cancel on the motion at hand and on no
other. So the spline's coefficients are expected to be those of a smooth function: a Gaussian
process whose size and length of variation along each coordinate have the largest evidence
(Rasmussen and Williams 2006, "Gaussian Processes for Machine Learning", sections 4.2 and 5.4). A
combination stays only where the data know it better than that expectation does: the
hard-threshold form of a ridge (Hoerl and Kennard 1970, Technometrics 12(1)) in the basis of
Demmler and Reinsch (1975, Numerische Mathematik 24). What is left is fitted by least squares
like everything else.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import eigh

from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.addition import normal_equations
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.dynamics.effects.arguments import VaryingInertia
from oed.dynamics.effects.coordinates import Coordinate
from oed.dynamics.effects.smooth_term import FreeForm

# Standard deviations that a combination of the expected size must measure, from what noise
# alone asks for to what a motion that leaves much of the range unvisited does.
KNOWN = (1.0, 3.0, 10.0, 30.0, 100.0)
LENGTHS = (0.06, 0.1, 0.17, 0.28, 0.47, 0.8)  # of a coordinate's range
START = 2  # of the lengths, where the climb begins
MOST_ROUNDS = 2
# Squared sizes of the expected function, over the noise of the combination known best.
SIZES = np.geomspace(1e-2, 1e8, 41)
NUGGET = 1e-6  # of a coefficient's variance, for the rounding of a factor


@dataclass(frozen=True)
class Left:
    """What a model leaves of the joints that a term acts on.

    Attributes:
        squares: Sum of the white residual's squares.
        freedom: Degrees of freedom.
    """

    squares: float
    freedom: float


@dataclass(frozen=True)
class Expectation:
    """What a term's coefficients are expected to be before they are fitted.

    Attributes:
        root: (f, f) factor of their covariance, over the noise's standard deviation.
        evidence: Log of the likelihood of the data, up to a constant.
    """

    root: Float[ndarray, "functions functions"]
    evidence: float


def restrained(trial: Trial, fit: LinearFit) -> Iterator[Trial]:
    """The term with its determined combinations alone, ever fewer of them.

    Args:
        trial: A free-form term, its group on the rows of the fit.
        fit: Of the model before it.

    Raises:
        TypeError: If the trial is no free-form term.
    """
    effect = trial.effect
    if not isinstance(effect, FreeForm):
        raise TypeError(f"{trial.name} is no free-form term")
    normal = normal_equations(fit.projection, fit.residual, trial.group)
    joints = list(trial.group)
    left = Left(float(np.sum(fit.residual[joints] ** 2)), float(np.sum(fit.freedom()[joints])))
    root = likeliest(effect, normal.gram, normal.moment, left).root
    values, vectors = eigh(root.T @ normal.gram @ root)
    for known in KNOWN:
        kept = values > known**2
        if not kept.any():
            break
        mixing = root @ vectors[:, kept]
        group = {joint: block @ mixing for joint, block in trial.group.items()}
        yield dataclasses.replace(
            trial, effect=dataclasses.replace(effect, mixing=mixing), group=group
        )


def likeliest(
    effect: FreeForm,
    gram: Float[ndarray, "functions functions"],
    moment: Float[ndarray, " functions"],
    left: Left,
) -> Expectation:
    """The expectation with the largest evidence, one length after another climbed.

    Args:
        effect: Its coordinates give the functions.
        gram: Of the white columns, beside the model.
        moment: Of the white residual with them.
        left: That residual's size.
    """
    smooth = [isinstance(c, Coordinate | VaryingInertia) for c in effect.coordinates]
    counts = [c.functions for c in effect.coordinates]
    tried: dict[tuple[int, ...], Expectation] = {}

    def at(place: tuple[int, ...]) -> Expectation:
        if place not in tried:
            root = np.ones((1, 1))
            for count, is_smooth, k in zip(counts, smooth, place, strict=True):
                factor = _smooth_root(count, LENGTHS[k]) if is_smooth else np.eye(count)
                root = np.kron(root, factor)
            tried[place] = _sized(root, gram, moment, left)
        return tried[place]

    here = (START,) * len(counts)
    for _ in range(MOST_ROUNDS):
        before = here
        for axis in (k for k, is_smooth in enumerate(smooth) if is_smooth):
            line = [(*here[:axis], k, *here[axis + 1 :]) for k in range(len(LENGTHS))]
            here = max(line, key=lambda place: at(place).evidence)
        if here == before:
            break
    return at(here)


def _smooth_root(count: int, length: float) -> Float[ndarray, "functions functions"]:
    """Cholesky factor of a squared exponential over the places of a spline's functions."""
    places = np.linspace(0.0, 1.0, count)
    distance = (places[:, None] - places[None, :]) / length
    return np.linalg.cholesky(np.exp(-(distance**2) / 2) + NUGGET * np.eye(count))


def _sized(
    root: Float[ndarray, "functions functions"],
    gram: Float[ndarray, "functions functions"],
    moment: Float[ndarray, " functions"],
    left: Left,
) -> Expectation:
    """A factor of unit size, brought to the size with the largest evidence.

    What the term cannot follow counts as noise, which is no smaller than it is stated.
    """
    values, vectors = eigh(root.T @ gram @ root)
    values = np.maximum(values, 0.0)
    squares = (vectors.T @ (root.T @ moment)) ** 2
    sizes = SIZES[:, None] / max(float(values[-1]), 1e-300)
    scaled = 1 + sizes * values
    rest = left.squares - np.sum(sizes * squares / scaled, axis=1)
    variance = np.maximum(rest / left.freedom, 1.0)
    fit = left.freedom * np.log(variance) + rest / variance
    evidence = -(fit + np.sum(np.log(scaled), axis=1)) / 2
    best = int(np.argmax(evidence))
    return Expectation(float(np.sqrt(sizes[best, 0])) * root, float(evidence[best]))
