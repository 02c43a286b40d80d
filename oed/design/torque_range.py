"""Proven bounds on the torque that a nominal model needs, by interval branch and bound.

Over a short stretch of time position, velocity and acceleration lie in intervals known from
their next two derivatives; the torque model, evaluated on intervals, then bounds the torque.
Stretches that might hold an extremum are split until the bound is tight enough.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.extrema import split_intervals
from oed.design.interval import Interval
from oed.design.trajectories import TrajectoryClass
from oed.dynamics.effects import Effect, State, with_columns
from oed.dynamics.scalars import Scalar
from oed.dynamics.torque_model import TorqueModel
from oed.errors import OedError

FIRST_INTERVALS = 2048  # of a motion of ten seconds, 5 ms each; the bound is valid for any number
LEVELS = 5  # of splitting in four; the bound is valid at every level
TOLERANCE = 5e-3  # between proven and attained torque, of the joint's largest


class TorqueNotBounded(OedError):
    """No bound on the torque can be proven for a model.

    Attributes:
        effect: Name of the effect that stands in the way.
    """

    def __init__(self, message: str, effect: str) -> None:
        super().__init__(message)
        self.effect = effect


def proven_torque_range(
    model: TorqueModel,
    parameters: Float[ndarray, "models parameters"],
    trajectory: TrajectoryClass,
    z: Float[ndarray, " size"],
) -> Float[ndarray, "joints 2"]:
    """Bounds that the model's torque never leaves, for all t in the horizon.

    Args:
        model: Its measurement effects are not seen.
        parameters: (m, p) each of which the bounds hold for: the nominal ones, and others.
        trajectory: The class.
        z: The motion.

    Raises:
        TorqueNotBounded: If an effect of the model cannot be evaluated on intervals.
    """
    ends = np.asarray(trajectory.breakpoints)
    edges = np.union1d(np.linspace(0.0, trajectory.horizon, FIRST_INTERVALS + 1), ends)
    middle, half = (edges[1:] + edges[:-1]) / 2, np.diff(edges) / 2
    n = trajectory.joints
    attained = np.stack([np.full(n, np.inf), np.full(n, -np.inf)])
    proven = attained.copy()
    for level in range(LEVELS):
        centre = model.columns(trajectory.motion(z, middle)) @ parameters.T
        attained[0] = np.minimum(attained[0], centre.min(axis=(0, 2)))
        attained[1] = np.maximum(attained[1], centre.max(axis=(0, 2)))
        q, dq, ddq = (_signal_on(trajectory, z, order, middle, half) for order in range(3))
        state = State(Interval(middle - half, middle + half), q, dq, ddq)
        lower, upper = _torque_on(model, parameters, state)
        gap = TOLERANCE * np.abs(attained).max(axis=0)
        is_open = ((lower < attained[0] - gap) | (upper > attained[1] + gap)).any(axis=1)
        if level == LEVELS - 1:
            is_open[:] = False
        if (~is_open).any():
            proven[0] = np.minimum(proven[0], lower[~is_open].min(axis=0))
            proven[1] = np.maximum(proven[1], upper[~is_open].max(axis=0))
        if not is_open.any():
            break
        middle, half = split_intervals(middle[is_open], half[is_open])
    return proven.T.copy()


def check_torque_bounded(
    model: TorqueModel, parameters: Float[ndarray, "models parameters"]
) -> None:
    """Ask, before the work, whether `proven_torque_range` can bound a model's torque.

    Args:
        model: As there, and so are the parameters.
        parameters: Effects count that any of them has a part of.

    Raises:
        TorqueNotBounded: If it cannot.
    """
    # Round a standstill, where an effect is least likely to have bounds.
    short = Interval(np.full(1, -1e-3), np.full(1, 1e-3))
    signals = [short] * model.robot.n
    _torque_on(model, parameters, State(short, signals, signals, signals))


def _torque_on(
    model: TorqueModel, parameters: Float[ndarray, "models parameters"], state: State
) -> tuple[ndarray, ndarray]:
    """Lower and upper torque (N, n) of intervals of motion, of whatever parameters."""
    shape = (len(parameters), len(state.t.lower), model.robot.n)
    lower, upper = np.zeros(shape), np.zeros(shape)
    for effect, place in with_columns(model.effects):
        sizes = parameters[:, place]
        if not np.any(sizes):
            continue
        for own, by_joint in zip(sizes.T, _entries(effect, state), strict=True):
            for joint, entry in by_joint.items():
                torque = Interval(own[:, None], own[:, None]) * entry
                lower[..., joint] += torque.lower
                upper[..., joint] += torque.upper
    return lower.min(axis=0), upper.max(axis=0)


def _entries(effect: Effect, state: State) -> Sequence[Mapping[int, Scalar]]:
    if effect.beyond_state:
        raise _not_bounded(effect, f"it depends on {effect.beyond_state[0]}")
    try:
        return effect.entries(state)
    # NotImplementedError where a function has no interval version, the others where an effect
    # wants the history of a sampled motion.
    except (NotImplementedError, ValueError, TypeError, AttributeError) as error:
        raise _not_bounded(effect, str(error)) from error


def _not_bounded(effect: Effect, reason: str) -> TorqueNotBounded:
    return TorqueNotBounded(
        f"the torque of {effect.name} cannot be bounded between instants ({reason}): leave it out "
        "of the nominal model, or the torque limits out of the design",
        effect.name,
    )


def _signal_on(
    trajectory: TrajectoryClass, z: ndarray, order: int, middle: ndarray, half: ndarray
) -> list[Interval]:
    value = trajectory.derivative(z, middle, order)
    slope = np.abs(trajectory.derivative(z, middle, order + 1))
    curvature = trajectory.derivative_bound(z, order + 2)
    reach = slope * half[:, None] + curvature * half[:, None] ** 2 / 2
    return [
        Interval(low, high) for low, high in zip((value - reach).T, (value + reach).T, strict=True)
    ]
