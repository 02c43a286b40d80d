"""Hidden friction: with speed, direction, load, position, heat, and with memory."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi
import numpy as np

from oed.dynamics.effects import State
from oed.dynamics.scalars import Scalar, cos, exp, magnitude, power, tanh
from oed.experiment.friction_memory import BristleFriction, MemoryTorque
from studies.bench.arm import Arm, direction
from studies.bench.injection import FIRST_SAMPLE, Injected, either_sign, wave_in_catalogue
from studies.bench.warmth import SwingingWarmth

ROUNDING = 0.01  # [rad/s] over which a power of speed below 1 leaves the origin
TYPICAL_SPEED = 1.5  # [rad/s] at which another speed law meets the straight line it replaces
LEAST_DEFLECTION = 5e-4  # [rad] below which the simulation's step is too long


def stribeck(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Friction that falls with speed, exponentially (Bo and Pavelescu 1982)."""
    rise, speed = 0.45 * size * arm.coulomb[joint], rng.uniform(0.04, 0.2)
    exponent = rng.uniform(1.0, 2.0)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        ratio = magnitude(state.dq[joint]) / speed
        fall = exp(-power(ratio + 1e-9, exponent))
        return {joint: rise * fall * direction(arm, state, joint)}

    values = {"Fs_*": rise, "speed": speed, "exponent": exponent}
    return Injected(arm.add(torque), in_catalogue=values)


def stribeck_lorentz(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """The same fall as 1 / (1 + (v / v_s)^2) (Hess and Soom 1990)."""
    rise, speed = 0.45 * size * arm.coulomb[joint], rng.uniform(0.04, 0.2)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        ratio = state.dq[joint] / speed
        return {joint: rise / (1.0 + ratio * ratio) * direction(arm, state, joint)}

    return Injected(arm.add(torque))


def power_of_speed(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Part of the viscous friction follows a power of speed."""
    share = 0.4 * size * arm.viscous[joint]
    exponent = rng.uniform(0.35, 0.65) if rng.random() < 0.5 else rng.uniform(1.7, 2.4)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        v = state.dq[joint]
        bend = power((v * v + ROUNDING**2) / TYPICAL_SPEED**2, (exponent - 1) / 2)
        return {joint: share * v * (bend - 1.0)}

    values = {"Fn_*": share * TYPICAL_SPEED ** (1 - exponent), "exponent": exponent}
    return Injected(arm.add(torque), in_catalogue=values)


def eyring(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Part of the viscous friction thins as asinh(v / v_0) (Eyring 1936)."""
    share, speed = 0.6 * size * arm.viscous[joint], rng.uniform(0.15, 0.5)
    scale = TYPICAL_SPEED / np.arcsinh(TYPICAL_SPEED / speed)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        v = state.dq[joint]
        return {joint: share * (scale * casadi.asinh(v / speed) - v)}

    return Injected(arm.add(torque))


def one_sided_viscous(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Viscous friction that differs between the directions."""
    slope = 0.3 * size * arm.viscous[joint] * either_sign(rng)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: slope * magnitude(state.dq[joint])}

    return Injected(arm.add(torque), {"slope": (slope, "N m s/rad")}, {"Fa_*": slope})


def rounded_one_sided_viscous(
    arm: Arm, joint: int, size: float, rng: np.random.Generator
) -> Injected:
    """The same with a round corner at standstill."""
    slope, corner = 0.35 * size * arm.viscous[joint] * either_sign(rng), rng.uniform(0.2, 0.4)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        v = state.dq[joint]
        return {joint: slope * (power(v * v + corner**2, 0.5) - corner)}

    return Injected(arm.add(torque))


def load_friction(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Friction in proportion to the rigid body's torque."""
    share = size * rng.uniform(0.06, 0.1)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        return {joint: share * magnitude(rigid[joint]) * direction(arm, state, joint)}

    return Injected(arm.add(torque), {"share": (share, "1")}, {"mu_*": share})


def total_load_friction(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Friction in proportion to all that the gear transmits, friction included, rounded at zero."""
    share, round_off = size * rng.uniform(0.06, 0.1), 0.1 * arm.coulomb[joint]

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        s = direction(arm, state, joint)
        total = rigid[joint] + arm.viscous[joint] * state.dq[joint] + arm.coulomb[joint] * s
        return {joint: share * power(total * total + round_off**2, 0.5) * s}

    return Injected(arm.add(torque))


def position_friction(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Coulomb friction that changes in waves along the joint's turn."""
    wave = 0.25 * size * arm.coulomb[joint]
    periods, phase = float(rng.integers(1, 5)), rng.uniform(0, 2 * np.pi)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        along = cos(periods * state.q[joint] + phase)
        return {joint: wave * along * direction(arm, state, joint)}

    return Injected(arm.add(torque), in_catalogue=wave_in_catalogue("Fq", wave, periods, phase))


def tight_spot(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Coulomb friction that is higher around one position."""
    rise, width = 0.5 * size * arm.coulomb[joint], rng.uniform(0.25, 0.5)
    middle = arm.robot.limits.position[joint].mean() + rng.uniform(-0.3, 0.3)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        away = (state.q[joint] - middle) / width
        return {joint: rise * exp(-away * away) * direction(arm, state, joint)}

    return Injected(arm.add(torque))


def cooling_start(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """All friction of a joint falls as it warms up, exponentially in time."""
    share, time = 0.3 * size, rng.uniform(40.0, 120.0)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: share * exp(-state.t / time) * _all_friction(arm, state, joint)}

    # The catalogue counts from the first sample that is logged.
    first = share * np.exp(-FIRST_SAMPLE / time)
    values = {
        "cold_Fv_*": first * arm.viscous[joint],
        "cold_Fc_*": first * arm.coulomb[joint],
        "time_constant": time,
    }
    return Injected(arm.add(torque), in_catalogue=values)


def swinging_warmth(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Friction of a joint falls with its temperature, which thermometers show."""
    warmth = SwingingWarmth.draw(joint, arm.robot.n, rng)
    slope = -0.25 * size / warmth.swing

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: slope * warmth.warmer(state.t) * _all_friction(arm, state, joint)}

    values = {
        "warming_Fv_*": slope * arm.viscous[joint],
        "warming_Fc_*": slope * arm.coulomb[joint],
    }
    return Injected(dataclasses.replace(arm.add(torque), temperature=warmth), in_catalogue=values)


def slow_warming(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """The same with a tail, 1 / (1 + t / T), in the viscous part more than in the dry one."""
    share, time = 0.4 * size, rng.uniform(30.0, 80.0)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        friction = 0.4 * arm.coulomb[joint] * direction(arm, state, joint)
        friction += arm.viscous[joint] * state.dq[joint]
        return {joint: share / (1.0 + state.t / time) * friction}

    return Injected(arm.add(torque))


def dahl(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Bristles that bend before they slip (Dahl 1968)."""
    deflection = max(size * rng.uniform(0.008, 0.025), LEAST_DEFLECTION)
    slip = BristleFriction(joint, arm.coulomb[joint], deflection)
    return Injected(dataclasses.replace(arm, slip={**arm.slip, joint: (slip,)}))


def maxwell_slip(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Four sorts of bristles side by side, each with its own reach."""
    reach = size * rng.uniform(0.01, 0.03) * np.array([0.15, 0.4, 0.8, 1.6])
    pieces = tuple(
        BristleFriction(joint, arm.coulomb[joint] / 4, max(float(r), LEAST_DEFLECTION))
        for r in reach
    )
    return Injected(dataclasses.replace(arm, slip={**arm.slip, joint: pieces}))


def bouc_wen(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A hysteresis loop with a sharper knee (Bouc 1967, Wen 1976)."""
    deflection = max(size * rng.uniform(0.008, 0.025), LEAST_DEFLECTION)
    slip = BoucWen(joint, arm.coulomb[joint], deflection)
    return Injected(dataclasses.replace(arm, slip={**arm.slip, joint: (slip,)}))


@dataclass(frozen=True)
class BoucWen(MemoryTorque):
    """z' = (dq - (|dq| z |z| + dq z^2) / 2) / deflection; torque F_c z.

    Attributes:
        joint: Index.
        coulomb: F_c [N m].
        deflection: [rad].
    """

    joint: int
    coulomb: float
    deflection: float

    @property
    def states(self) -> int:
        """The loop variable z, between -1 and 1."""
        return 1

    @property
    def fastest(self) -> float:
        """At z = 1 the decay is twice that of a bristle."""
        return 2.0 / self.deflection

    def rate(self, state: State, memory: Sequence[Scalar]) -> Sequence[Scalar]:
        """Of z."""
        v, z = state.dq[self.joint], memory[0]
        return [(v - 0.5 * (magnitude(v) * z * magnitude(z) + v * z * z)) / self.deflection]

    def torque(self, state: State, memory: Sequence[Scalar]) -> Mapping[int, Scalar]:
        """F_c z."""
        del state
        return {self.joint: self.coulomb * memory[0]}


def unequal_directions(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """More Coulomb friction one way than the other: half of it is a constant torque."""
    excess = 0.7 * size * arm.coulomb[joint] * either_sign(rng)

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {joint: 0.5 * excess * (1.0 + tanh(state.dq[joint] / arm.width[joint]))}

    return Injected(arm.add(torque), {"offset": (0.5 * excess, "N m")})


def _all_friction(arm: Arm, state: State, joint: int) -> Scalar:
    """Coulomb and viscous friction of a joint as it slides [N m]."""
    return arm.coulomb[joint] * direction(arm, state, joint) + arm.viscous[joint] * state.dq[joint]
