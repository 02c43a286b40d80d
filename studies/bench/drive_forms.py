"""Hidden in the drive and the instruments: rotors, gears, gain, lag, and the encoder."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from oed.dynamics.effects import State
from oed.dynamics.scalars import Scalar, magnitude
from studies.bench.arm import (
    Arm,
    Series,
    Transmission,
    direction,
    least_inertia,
    loose,
    mass_matrices,
)
from studies.bench.injection import Injected, either_sign

MOST_COUPLED = 0.5  # of the root of two joints' least inertias
ROTOR_SHARE = 0.4  # of a flexible joint's inertia
BEARING = 0.6  # of a loose joint's friction sits on the link's side
CONTACT = 2 * np.pi * 25.0  # [rad/s] of a link on its gear teeth


def rotor(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Inertia that turns with the joint's own speed alone."""
    inertia = size * rng.uniform(0.08, 0.14) * _inertia(arm, joint)
    return Injected(
        arm.add(lambda state, _rigid: {joint: inertia * state.ddq[joint]}),
        {"inertia": (inertia, "kg m^2")},
        {"Ia_*": inertia},
    )


def neighbour_motor(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """The outer neighbour's motor pushes on this joint: its inertia and its friction."""
    other = joint + 1
    inertia = size * rng.uniform(0.1, 0.2) * _inertia(arm, other)
    # No more than the mass matrix bears beside it anywhere.
    least, _ = least_inertia(arm.robot, np.random.default_rng(0))
    inertia = min(inertia, MOST_COUPLED * float(np.sqrt(least[joint] * least[other])))
    dry, viscous = (0.15 * size * x[other] for x in (arm.coulomb, arm.viscous))

    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        friction = viscous * state.dq[other] + dry * direction(arm, state, other)
        return {
            joint: inertia * state.ddq[other] + friction,
            other: inertia * state.ddq[joint],
        }

    pair = f"x{joint + 1}{other + 1}"
    values = {f"Ia_{pair}": inertia, f"Fv_{pair}": viscous, f"Fc_{pair}": dry}
    return Injected(arm.add(torque), in_catalogue=values)


def gain(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """The torque signal reads in proportion too much or too little."""
    error = size * rng.uniform(0.06, 0.1) * either_sign(rng)

    def change(torque: Series, period: float) -> Series:
        del period
        changed = torque.copy()
        changed[:, joint] *= 1 + error
        return changed

    return Injected(arm.change_torque(change), {"error": (error, "1")}, {"gain*": error})


def rising_current(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Near its peak the motor needs more current for the same torque: a cubic."""
    at_peak, peak = size * rng.uniform(0.08, 0.14), arm.peak[joint]

    def change(torque: Series, period: float) -> Series:
        del period
        changed = torque.copy()
        changed[:, joint] *= 1 + at_peak * (torque[:, joint] / peak) ** 2
        return changed

    return Injected(arm.change_torque(change))


def squeezed_signal(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """The torque signal flattens near its peak, as a tanh."""
    at_peak = size * rng.uniform(0.08, 0.14)
    reach = arm.peak[joint] / np.sqrt(3 * at_peak)

    def change(torque: Series, period: float) -> Series:
        del period
        changed = torque.copy()
        changed[:, joint] = reach * np.tanh(torque[:, joint] / reach)
        return changed

    return Injected(arm.change_torque(change))


def late_torque(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """All torque signals come late."""
    del joint
    delay = size * rng.uniform(0.005, 0.012)

    def change(torque: Series, period: float) -> Series:
        # Between samples by a cubic: a line between two of them would lag besides.
        t = np.arange(len(torque)) * period
        return CubicSpline(t, torque)(np.maximum(t - delay, 0.0))

    return Injected(arm.change_torque(change), {"delay": (delay, "s")}, {"delay": delay})


def lagging_torque(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """All torque signals go through one low-pass of first order."""
    del joint
    time = size * rng.uniform(0.005, 0.012)
    return Injected(
        arm.change_torque(lambda torque, period: _low_pass(torque, time, period)),
        {"time": (time, "s")},
        {"time_constant": time},
    )


def twice_lagging_torque(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """All torque signals go through two equal low-passes."""
    del joint
    time = size * rng.uniform(0.004, 0.008)

    def change(torque: Series, period: float) -> Series:
        return _low_pass(_low_pass(torque, time, period), time, period)

    return Injected(arm.change_torque(change))


def elastic(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """The link swings on a linear spring behind motor and encoder."""
    stiffness, inertia, rate = _spring(arm, joint, size, rng)
    damping = 0.1 * stiffness / rate

    def law(bend: Scalar, speed: Scalar) -> Scalar:
        return stiffness * bend + damping * speed

    found = _behind(arm, Transmission(joint, ROTOR_SHARE * inertia, law, 0.0))
    if joint + 1 < arm.robot.n:  # its inertia hangs on the posture, and the frequency with it
        return found
    return dataclasses.replace(found, in_catalogue={"frequency": rate / (2 * np.pi)})


def hardening_elastic(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """The same on a spring that stiffens, as a harmonic drive's does."""
    stiffness, inertia, rate = _spring(arm, joint, size, rng)
    damping, knee = 0.1 * stiffness / rate, 0.5 * arm.peak[joint] / stiffness

    def law(bend: Scalar, speed: Scalar) -> Scalar:
        ratio = bend / knee
        return stiffness * bend * (1.0 + 0.5 * ratio * ratio) + damping * speed

    return _behind(arm, Transmission(joint, ROTOR_SHARE * inertia, law, 0.0))


def loose_gear(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """Teeth with a gap: a stiff spring that bears on one flank or the other."""
    gap, inertia = size * rng.uniform(0.0006, 0.002), _inertia(arm, joint)
    stiffness = inertia * CONTACT**2
    damping, grease = 1.2 * stiffness / CONTACT, 0.02 * stiffness / CONTACT

    def law(bend: Scalar, speed: Scalar) -> Scalar:
        beyond = loose(bend, gap)
        touching = magnitude(bend) > gap / 2
        return stiffness * beyond + (grease + damping * touching) * speed

    found = _behind(arm, Transmission(joint, 0.5 * inertia, law, BEARING))
    return dataclasses.replace(found, parameters={"gap": (gap, "rad")}, in_catalogue={"gap": gap})


def eccentric_encoder(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """The encoder's disc runs out of true, once a turn."""
    return _misread(arm, joint, 2.5e-3 * size, rng.uniform(0, 2 * np.pi), 1.0)


def oval_encoder(arm: Arm, joint: int, size: float, rng: np.random.Generator) -> Injected:
    """A magnetic ring that errs twice a turn."""
    return _misread(arm, joint, 1.5e-3 * size, rng.uniform(0, 2 * np.pi), 2.0)


def _misread(arm: Arm, joint: int, error: float, phase: float, periods: float) -> Injected:
    def change(position: Series, period: float) -> Series:
        del period
        # The model evaluates at what it reads: the arm is where the reading is corrected to.
        changed = position.copy()
        changed[:, joint] -= error * np.sin(periods * position[:, joint] + phase)
        return changed

    if periods != 1:
        return Injected(arm.change_position(change))
    sine, cosine = float(error * np.cos(phase)), float(error * np.sin(phase))
    return Injected(
        arm.change_position(change),
        {"error": (error, "rad")},
        {"encoder_sin_*": sine, "encoder_cos_*": cosine},
    )


def _behind(arm: Arm, transmission: Transmission) -> Injected:
    if arm.transmission is not None:
        raise ValueError("an arm of the bench has one flexible or loose joint at most")
    return Injected(dataclasses.replace(arm, transmission=transmission))


def _spring(
    arm: Arm, joint: int, size: float, rng: np.random.Generator
) -> tuple[float, float, float]:
    """Stiffness [N m/rad], inertia [kg m^2] and rate of the link on its spring [rad/s]."""
    rate = 2 * np.pi * rng.uniform(5.0, 8.0) / np.sqrt(size)
    inertia = _inertia(arm, joint)
    return inertia * rate**2, inertia, rate


def _low_pass(torque: Series, time: float, period: float) -> Series:
    """1 / (1 + T s) by the bilinear rule: a ramp comes late by T, as from the filter itself."""
    memory = (2 * time - period) / (2 * time + period)
    gain = period / (2 * time + period)
    start = (gain + memory) * torque[:1]
    return lfilter([gain, gain], [1, -memory], torque, axis=0, zi=start)[0]


def _inertia(arm: Arm, joint: int) -> float:
    """About a joint, in the middle of the workspace [kg m^2]."""
    middle = arm.robot.limits.position.mean(axis=1)[None]
    return float(mass_matrices(arm.robot, middle)[0, joint, joint])
