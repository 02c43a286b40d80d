"""Estimates from sums over rows: a recording is its normal equations, joint by joint."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.dynamics.effects import State
from oed.dynamics.effects.nonlinear_viscous import NonlinearViscous
from oed.dynamics.effects.stribeck import Stribeck
from oed.dynamics.motion import Motion
from oed.experiment.paper_signals import SampledRuns, paper_regressor
from oed.robot.builtin import IMI_LINK_LENGTHS
from studies.paper_experiment.laboratory import JOINTS

XI = 8  # parameters of the paper's model (16)
# The richer friction model has two textbook terms a joint, a rise towards standstill (Stribeck)
# and viscous friction that thins. Their speeds are not given to it: of these [rad/s], a factor
# of four apart and neither the arm's own, it takes the pair that leaves least on the rows that
# it is fitted to.
STRIBECK_SPEEDS, THINNING_SPEEDS = (0.05, 0.2), (0.5, 2.0)
EXTRA = tuple(
    effect
    for j in range(JOINTS)
    for effect in (
        *(Stribeck(j, speed) for speed in STRIBECK_SPEEDS),
        *(NonlinearViscous(j, thinning=1 / speed) for speed in THINNING_SPEEDS),
    )
)
PLAIN = tuple(range(XI))
RICH = tuple(
    (
        *PLAIN,
        *(
            XI + k
            for k, effect in enumerate(EXTRA)
            if effect
            in (Stribeck(effect.joint, low), NonlinearViscous(effect.joint, 1.0, 1 / thin))
        ),
    )
    for low, thin in itertools.product(STRIBECK_SPEEDS, THINNING_SPEEDS)
)


def regressor(motion: Motion) -> Float[ndarray, "samples 2 columns"]:
    """The paper's columns (16), then all that a richer friction model may take."""
    state = State.along(motion)
    extra = np.zeros((len(motion), JOINTS, len(EXTRA)))
    for k, effect in enumerate(EXTRA):
        extra[:, effect.joint, k] = effect.entries(state)[0][effect.joint]
    return np.concatenate([paper_regressor(motion), extra], axis=2)


T = TypeVar("T")  # a frozen dataclass of arrays and numbers


def stacked(parts: Sequence[T], axis: int = 0) -> T:
    """Several as one, along a new axis."""
    names = [field.name for field in fields(parts[0])]  # type: ignore[arg-type]
    return type(parts[0])(*(np.stack([getattr(p, name) for p in parts], axis) for name in names))


@dataclass(frozen=True)
class Sums:
    """All that least squares wants of a recording.

    Attributes:
        gram: (..., n, c, c) sum of the products of a joint's columns.
        moment: (..., n, c) of its columns and its torque.
        square: (..., n) of its torque with itself [N^2 m^2].
        rows: (..., n) of each joint.
    """

    gram: Float[ndarray, "*cells n c c"]
    moment: Float[ndarray, "*cells n c"]
    square: Float[ndarray, "*cells n"]
    rows: Int[ndarray, "*cells n"]

    @classmethod
    def of(cls, runs: SampledRuns) -> Sums:
        """Those of some repetitions."""
        columns = runs.columns.reshape(-1, JOINTS, runs.columns.shape[3]).transpose(1, 0, 2)
        torque = runs.tau.reshape(-1, JOINTS).T
        return cls(
            columns.transpose(0, 2, 1) @ columns,
            (columns * torque[:, :, None]).sum(axis=1),
            (torque**2).sum(axis=1),
            np.full(JOINTS, torque.shape[1]),
        )

    def squared_residual(
        self, parameters: Float[ndarray, "*cells c"]
    ) -> Float[ndarray, "*cells n"]:
        """Mean square of what parameters leave, joint by joint [N^2 m^2]."""
        xi = parameters[..., None, :]
        explained = (xi * (2 * self.moment - np.squeeze(self.gram @ xi[..., None], -1))).sum(
            axis=-1
        )
        return (self.square - explained) / self.rows

    def relative(self, parameters: Float[ndarray, "*cells c"]) -> Float[ndarray, "*cells n"]:
        """Rms residual over rms torque."""
        return np.sqrt(self.squared_residual(parameters) / (self.square / self.rows))

    def fit(
        self, variances: Float[ndarray, " n"], columns: tuple[int, ...]
    ) -> tuple[Float[ndarray, " c"], Float[ndarray, "own own"]]:
        """Weighted least squares (7) with some of the columns; zero for all others.

        Well conditioned by design, cond Lambda of tens to hundreds: normal equations do.

        Args:
            variances: Of the torque of each joint [N^2 m^2].
            columns: The model's.

        Returns:
            Parameters, and P of (8) of the model's own.
        """
        own = np.ix_(range(JOINTS), columns, columns)
        information = (self.gram[own] / variances[:, None, None]).sum(axis=0)
        moment = (self.moment[:, columns] / variances[:, None]).sum(axis=0)
        parameters = np.zeros(self.moment.shape[-1])
        parameters[list(columns)] = np.linalg.solve(information, moment)
        return parameters, np.linalg.inv(information)

    def fit_rich(self, variances: Float[ndarray, " n"]) -> Float[ndarray, " c"]:
        """With the friction model of `RICH` that leaves least on these very rows."""
        found = [self.fit(variances, columns)[0] for columns in RICH]
        return min(found, key=lambda xi: float((self.squared_residual(xi) / variances).sum()))


def infeasible(parameters: Float[ndarray, "*cells 8"]) -> Bool[ndarray, "*cells"]:
    """Whether no arm of positive masses and no friction that dissipates has these parameters.

    Some m_2 > 0 must give the first link an inertia Gamma_1z > 0 and the second a centre of
    mass within its inertia, |m_2 s_2|^2 < m_2 Gamma_2z: together l_1^2 |m_2 s_2|^2 < Gamma_2z
    (Gamma_1z + m_2 l_1^2).
    """
    total, x, y, second = np.moveaxis(parameters[..., :4], -1, 0)
    room = second * total - IMI_LINK_LENGTHS[0] ** 2 * (x**2 + y**2)
    friction = parameters[..., 4:].min(axis=-1)
    return (total <= 0) | (second <= 0) | (room <= 0) | (friction < 0)
