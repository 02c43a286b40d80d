"""Hidden torques that no catalogue of single causes holds; what counts is where they live."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from oed.dynamics.effects import State
from oed.dynamics.scalars import Scalar, add, cos, magnitude, sin
from oed.experiment.friction_memory import MemoryTorque
from studies.bench.arm import Arm, direction
from studies.bench.injection import Injected, another_joint, named


def drag_of_a_bundle(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Viscous drag of a cable bundle that the neighbour's position tightens."""
    other = another_joint(arm, joint, rng)
    drag, phase = 0.4 * size * arm.coulomb[joint], rng.uniform(0, 2 * np.pi)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: drag * sin(1.7 * state.q[other] + phase) * state.dq[joint]}

    return Injected(arm.add(torque), coordinates=(named(f"q_{other}", f"dq_{joint}"),))


def drag_along_the_turn(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Viscous friction in proportion to position: grease that has run to one side."""
    slope = 0.35 * size * arm.coulomb[joint]
    middle = float(arm.robot.limits.position[joint].mean()) + rng.uniform(-0.2, 0.2)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: slope * (state.q[joint] - middle) * state.dq[joint]}

    return Injected(arm.add(torque), coordinates=(named(f"q_{joint}", f"dq_{joint}"),))


def landscape(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A smooth, arbitrary function of two positions."""
    other = another_joint(arm, joint, rng)
    height = 0.35 * size * arm.coulomb[joint]
    waves, phases = rng.uniform(1.2, 3.2, (5, 2)), rng.uniform(0, 2 * np.pi, (5, 2))
    weights = rng.standard_normal(5)
    weights *= 2 / np.linalg.norm(weights)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        value: Scalar = 0.0
        for weight, (a, b), (c, d) in zip(weights, waves, phases, strict=True):
            own = cos(float(a) * state.q[joint] + float(c))
            value = add(value, float(weight) * own * cos(float(b) * state.q[other] + float(d)))
        return {joint: height * value}

    return Injected(arm.add(torque), coordinates=(named(f"q_{joint}", f"q_{other}"),))


def modulated_cogging(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Cogging whose strength the neighbour's position changes, through the air gap."""
    other = another_joint(arm, joint, rng)
    wave, periods = 0.4 * size * arm.coulomb[joint], float(rng.integers(3, 7))
    first, second = rng.uniform(0, 2 * np.pi, 2)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        strength = sin(2.0 * state.q[other] + second)
        return {joint: wave * strength * cos(periods * state.q[joint] + first)}

    return Injected(arm.add(torque), coordinates=(named(f"q_{joint}", f"q_{other}"),))


def fanned_drag(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Drag of this joint in proportion to the neighbour's speed."""
    other = another_joint(arm, joint, rng)
    drag = 0.5 * size * arm.coulomb[joint]

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: drag * magnitude(state.dq[other]) * direction(arm, state, joint)}

    return Injected(arm.add(torque), coordinates=(named(f"dq_{other}", f"dq_{joint}"),))


def shaking_floor(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A machine next door, at a frequency of its own."""
    wave, rate = 0.3 * size * arm.coulomb[joint], 2 * np.pi * rng.uniform(1.3, 3.0)
    phase = rng.uniform(0, 2 * np.pi)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: wave * sin(rate * state.t + phase)}

    return Injected(arm.add(torque), coordinates=(("time",), ("frequency",), ("repetition",)))


def dragged_hose(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A hose that the neighbour drags: a wide loop against its position pulls on this joint."""
    other = another_joint(arm, joint, rng)
    hose = Hose(joint, other, 0.5 * size * arm.coulomb[joint], rng.uniform(0.15, 0.35))
    changed = dataclasses.replace(arm, memory=(*arm.memory, hose))
    either = (
        named(f"q_{other}", f"dq_{other}"),
        named(f"q_{other}"),
        named(f"dq_{other}"),
    )
    return Injected(changed, coordinates=either)


@dataclass(frozen=True)
class Hose(MemoryTorque):
    """Friction loop of one joint's position, felt by another.

    Attributes:
        joint: That feels it.
        other: Whose motion drags.
        pull: Greatest torque [N m].
        reach: Width of the loop [rad].
    """

    joint: int
    other: int
    pull: float
    reach: float

    @property
    def states(self) -> int:
        """The share of the greatest torque."""
        return 1

    @property
    def fastest(self) -> float:
        """1 / reach."""
        return 1.0 / self.reach

    def rate(self, state: State, memory: Sequence[Scalar]) -> Sequence[Scalar]:
        """Towards the direction of motion."""
        speed = state.dq[self.other]
        return [(speed - magnitude(speed) * memory[0]) / self.reach]

    def torque(self, state: State, memory: Sequence[Scalar]) -> Mapping[int, Scalar]:
        """Of the loop."""
        del state
        return {self.joint: self.pull * memory[0]}
