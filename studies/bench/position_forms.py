"""Hidden torques that hang on position: offsets, springs, ripple, and gravity from elsewhere."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from oed.dynamics.effects import State
from oed.dynamics.effects.gravity import tilt_directions
from oed.dynamics.newton_euler import inverse_dynamics
from oed.dynamics.scalars import Scalar, cos, power
from oed.robot.inertia import parameters_from_pseudo_inertia
from studies.bench.arm import Arm
from studies.bench.injection import Injected, either_sign, middle, wave_in_catalogue

# With or without repetitions, the first recording has ended or is about half over by then.
PAYLOAD_MOMENT = 42.0  # [s]


def constant(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A constant torque."""
    value = 0.35 * size * arm.coulomb[joint] * either_sign(rng)
    return Injected(
        arm.add(lambda _state, _rigid: {joint: value}),
        {"offset": (value, "N m")},
        {"offset_*": value},
    )


def ripple(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """One line in position."""
    wave, periods = 0.15 * size * arm.coulomb[joint], float(rng.integers(6, 40))
    phase = rng.uniform(0, 2 * np.pi)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: wave * cos(periods * state.q[joint] + phase)}

    values = wave_in_catalogue("ripple", wave, periods, phase)
    return Injected(arm.add(torque), {"wave": (wave, "N m")}, values)


def ripple_with_overtone(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A line and its double, as teeth that mesh unevenly give."""
    wave, periods = 0.15 * size * arm.coulomb[joint], float(rng.integers(6, 20))
    first, second = rng.uniform(0, 2 * np.pi, 2)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        angle = periods * state.q[joint]
        return {joint: wave * (cos(angle + first) + 0.5 * cos(2.0 * angle + second))}

    return Injected(arm.add(torque))


def spring(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A linear spring about some rest position."""
    stiffness = 0.8 * size * arm.coulomb[joint] * rng.uniform(0.7, 1.3)
    rest = middle(arm, joint) + rng.uniform(-0.4, 0.4)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: stiffness * (state.q[joint] - rest)}

    values = {f"spring_{joint + 1}": stiffness}
    return Injected(arm.add(torque), {"stiffness": (stiffness, "N m/rad")}, values)


def tightening_cable(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A spring that stiffens as the cable goes taut."""
    stiffness = 0.6 * size * arm.coulomb[joint] * rng.uniform(0.7, 1.3)
    rest = middle(arm, joint) + rng.uniform(-0.4, 0.4)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        stretch = state.q[joint] - rest
        return {joint: stiffness * stretch * power(1.0 + stretch * stretch, 0.5)}

    return Injected(arm.add(torque))


def tilted_base(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """The base stands tilted about a level axis."""
    del joint
    angle = np.deg2rad(2.5) * size
    heading = rng.uniform(0, 2 * np.pi)
    g = arm.robot.gravity
    axes, size_of_g = tilt_directions(g)
    level = np.array([np.cos(heading), np.sin(heading), 0.0]) * size_of_g
    tilted = np.cos(angle) * g + np.sin(angle) * level
    return Injected(
        dataclasses.replace(arm, robot=arm.robot.with_gravity(tilted)),
        {"angle": (float(angle), "rad")},
        {f"tilt_{k + 1}": float(angle * (axis @ level) / size_of_g) for k, axis in enumerate(axes)},
    )


def payload_from_then_on(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """The last link carries something from a moment on."""
    del joint
    n = arm.robot.n
    mass = 0.2 * size * float(arm.robot.parameters[10 * (n - 1)])
    centre = np.array([0.2, 0.03, 0.0]) if n == 2 else np.array([0.06, 0.04, 0.12])
    pseudo = np.zeros((4, 4))
    pseudo[:3, :3] = mass * (np.outer(centre, centre) + 2e-4 * np.eye(3))
    pseudo[:3, 3] = pseudo[3, :3] = mass * centre
    pseudo[3, 3] = mass
    alone = np.zeros(10 * n)
    alone[-10:] = parameters_from_pseudo_inertia(pseudo)
    carried = arm.robot.with_parameters(alone)
    moment = PAYLOAD_MOMENT * rng.uniform(0.9, 1.1)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        needed = inverse_dynamics(carried, state.q, state.dq, state.ddq)
        return {j: (state.t > moment) * needed[j] for j in range(n)}

    names = arm.robot.parameter_names
    values = {f"load_{name}": float(x) for name, x in zip(names, alone, strict=True) if x != 0}
    return Injected(
        dataclasses.replace(arm.add(torque), session=True), {"mass": (mass, "kg")}, values
    )
