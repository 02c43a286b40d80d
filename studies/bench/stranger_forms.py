"""More hidden torques that no catalogue of single causes holds: drives, tethers, pads, brakes."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from oed.dynamics.effects import State
from oed.dynamics.scalars import Scalar, cos, power, sin, tanh
from oed.experiment.friction_memory import MemoryTorque
from studies.bench.arm import Arm, direction, mass_matrices
from studies.bench.injection import Injected, another_joint, either_sign, middle, named

KINK = 0.03  # [rad] over which a tether or strap goes taut
# Cycles a second of a brake's three rhythms: together they do not come back within a session.
RHYTHMS = ((0.04, 0.08), (0.1, 0.17), (0.2, 0.3))  # [Hz]
CLOSING = 0.1  # of the rhythms' sum, over which the brake closes
OPEN = 0.3  # sum of the rhythms below which it is open


def pumped_balancer(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Oil that the neighbour pumps pushes on a lever that passes its dead centre."""
    other = another_joint(arm, joint, rng)
    push = 0.6 * size * arm.coulomb[joint] * either_sign(rng)
    centre = middle(arm, joint) + rng.uniform(-0.2, 0.2)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: push * sin(1.5 * (state.q[joint] - centre)) * state.dq[other]}

    return Injected(arm.add(torque), coordinates=(named(f"q_{joint}", f"dq_{other}"),))


def connecting_rod(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A flywheel behind a crank: inertia J(q), and with it the torque J'(q) dq^2 / 2."""
    middle = arm.robot.limits.position.mean(axis=1)[None]
    inertia = 0.3 * size * float(mass_matrices(arm.robot, middle)[0, joint, joint])
    phase = rng.uniform(0, 2 * np.pi)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        angle, v = 2.0 * state.q[joint] + phase, state.dq[joint]
        return {joint: inertia * ((1.0 + cos(angle)) * state.ddq[joint] - sin(angle) * v * v)}

    # The part with the acceleration dominates: without the speed, two thirds are still said.
    most = named(f"q_{joint}", f"ddq_{joint}")
    whole = named(f"q_{joint}", f"dq_{joint}", f"ddq_{joint}")
    return Injected(arm.add(torque), coordinates=(most, whole))


def stray_field(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """The field of a machine nearby turns slowly, and pulls on the poles of this motor."""
    wave, rate = 0.65 * size * arm.coulomb[joint], 2 * np.pi * rng.uniform(0.13, 0.37)
    poles = float(rng.integers(1, 4))
    first, second = rng.uniform(0, 2 * np.pi, 2)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: wave * sin(rate * state.t + first) * cos(poles * state.q[joint] + second)}

    return Injected(arm.add(torque), coordinates=_in_time(f"q_{joint}"))


def sliding_pad(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A pad that both joints slide, crosswise: friction points against the sum of the two."""
    other = another_joint(arm, joint, rng)
    friction, ratio = 0.9 * size * arm.coulomb[joint], rng.uniform(0.7, 1.4)
    least = arm.width[joint]

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        v, across = state.dq[joint], ratio * state.dq[other]
        return {joint: friction * v / power(v * v + across * across + least**2, 0.5)}

    return Injected(arm.add(torque), coordinates=(named(f"dq_{joint}", f"dq_{other}"),))


def brake_of_its_own_mind(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A holding brake whose coil fails: it drags for seconds, at times that nothing foretells."""
    drag = 0.7 * size * arm.coulomb[joint]
    rates = [2 * np.pi * float(rng.uniform(*rhythm)) for rhythm in RHYTHMS]
    phases = rng.uniform(0, 2 * np.pi, len(rates)).tolist()

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        level = -OPEN
        for rate, phase in zip(rates, phases, strict=True):
            level += sin(rate * state.t + phase)
        closed = 0.5 * (1.0 + tanh(level / CLOSING))
        return {joint: drag * closed * direction(arm, state, joint)}

    return Injected(arm.add(torque), coordinates=_in_time(f"dq_{joint}"))


def slack_tether(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A rubber tether over both joints' pulleys that pulls once the two have taken up its slack."""
    other = another_joint(arm, joint, rng)
    stiffness = 0.85 * size * arm.coulomb[joint] / _reach(arm, joint) * either_sign(rng)
    ratio, slack = rng.uniform(0.8, 1.3) * either_sign(rng), rng.uniform(-0.2, 0.3)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        own, far = state.q[joint] - middle(arm, joint), state.q[other] - middle(arm, other)
        stretch = own + ratio * far - slack
        return {joint: 0.5 * stiffness * (stretch + power(stretch * stretch + KINK**2, 0.5))}

    return Injected(arm.add(torque), coordinates=(named(f"q_{joint}", f"q_{other}"),))


def creeping_strap(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A strap that the neighbour stretches either way; half of the stretch creeps out of it."""
    other = another_joint(arm, joint, rng)
    centre, reach = middle(arm, other) + rng.uniform(-0.2, 0.2), _reach(arm, other)
    pull = 1.7 * size * arm.coulomb[joint] / reach * either_sign(rng)
    strap = CreepingStrap(joint, other, pull, rng.uniform(1.0, 3.0), centre, 0.25 * reach)
    changed = dataclasses.replace(arm, memory=(*arm.memory, strap))
    # The crept part lags, so that the speed adds a little to what the position says.
    either = (named(f"q_{other}"), named(f"q_{other}", f"dq_{other}"))
    return Injected(changed, coordinates=either)


@dataclass(frozen=True)
class CreepingStrap(MemoryTorque):
    """w' = (x - w) / T with x = q_other - middle; torque as |x - w / 2| less its usual value.

    Attributes:
        joint: That feels it.
        other: That stretches it.
        pull: Torque for a radian of stretch [N m/rad].
        time: T, of creep [s].
        middle: Where the fresh strap is slack [rad].
        usual: Stretch whose pull a constant spring balances [rad].
    """

    joint: int
    other: int
    pull: float
    time: float
    middle: float
    usual: float

    @property
    def states(self) -> int:
        """The creep w [rad]."""
        return 1

    @property
    def fastest(self) -> float:
        """It forgets with time alone, slowly."""
        return 0.0

    def rate(self, state: State, memory: Sequence[Scalar]) -> Sequence[Scalar]:
        """Of the creep."""
        return [(state.q[self.other] - self.middle - memory[0]) / self.time]

    def torque(self, state: State, memory: Sequence[Scalar]) -> Mapping[int, Scalar]:
        """Either way alike."""
        left = state.q[self.other] - self.middle - 0.5 * memory[0]
        return {self.joint: self.pull * (power(left * left + KINK**2, 0.5) - self.usual)}


def _in_time(coordinate: str) -> tuple[tuple[str, ...], ...]:
    """What depends on the clock and on one coordinate, or just on the clock, as shaking does."""
    clock = ("time", "repetition")
    return (*(named(coordinate, word) for word in clock), *((word,) for word in clock))


def _reach(arm: Arm, joint: int) -> float:
    """From the middle to either end [rad]."""
    return float(np.ptp(arm.robot.limits.position[joint])) / 2
