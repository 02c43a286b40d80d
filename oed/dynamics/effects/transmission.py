"""A joint that yields: its links hang on a spring behind motor and encoder, with or without play."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import no_type_check

import numba
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect, MeasurementEffect, Parameter, State
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.motion import Motion, with_joint
from oed.dynamics.newton_euler import joint_components
from oed.dynamics.scalars import Scalar

# Of the inertia where it was declared: an estimated inertia may come out too small or negative
# in some posture, and the spring would throw the links out.
LEAST_INERTIA = 0.1


@dataclass(frozen=True)
class Bend:
    """Deflection of a joint's gear, motor angle less link angle, and its derivatives.

    Attributes:
        d: (samples,) deflection [rad or m].
        dd: (samples,) its rate.
        ddd: (samples,) its acceleration.
    """

    d: Float[ndarray, " samples"]
    dd: Float[ndarray, " samples"]
    ddd: Float[ndarray, " samples"]


@dataclass(frozen=True)
class Transmission(MeasurementEffect):
    """The rigid body at the links' position q - delta, delta what a joint's gear gives way.

    The two masses of Spong (1987) on the dead zone of Nordin and Gutman (2002), the position
    measured at the motor. On a flank the gear pushes with K (delta -+ gap/2) + D delta', within
    the gap not at all; it pushes what the links need, H(q - delta)_j less the rotor's share J q''
    and with the friction of their own bearing. With the inertia M_jj of the rigid model, in
    which the rotor is counted with the link, to first order in delta

        push(delta, delta') + (M_jj - J) delta'' = H(q)_j - J q'' + bearing friction_j,

    solved in time along the recording. *All* joints then feel the links where they are, and
    the rotor, which does not give way, adds J delta'' at its own.

    Attributes:
        joint: Index of the joint.
        frequency: Of the links on the spring with the motor held, at `posture` [Hz].
        damping: D / (2 sqrt(K M)), M of the links at `posture`.
        rotor_share: J / M_jj at `posture`, below 1.
        gap: Play between the flanks [rad or m].
        bearing: Share of the joint's friction that sits behind the gear.
        posture: (n,) position where these are declared [rad or m].
        reference: Gives the load.
        rigid_columns: The leading columns are the rigid body's.
    """

    joint: int
    frequency: float
    damping: float
    rotor_share: float
    gap: float
    bearing: float
    posture: tuple[float, ...]
    reference: ReferenceTorque
    rigid_columns: int
    name = "transmission"

    def __post_init__(self) -> None:
        if self.frequency <= 0 or self.damping <= 0:
            raise ValueError(f"{self.frequency=} and {self.damping=} must be positive")
        if not 0 <= self.rotor_share < 1:
            raise ValueError(f"{self.rotor_share=} must be at least 0 and below 1")
        if self.gap < 0 or not 0 <= self.bearing <= 1:
            raise ValueError(f"{self.gap=} must not be negative, {self.bearing=} in 0 to 1")

    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns with the rigid body where the links are."""
        result, rigid = np.array(columns(motion)), slice(self.rigid_columns)
        bend = self.bend(State(motion.t, *joint_components(motion)))
        result[:, :, rigid] = columns(with_joint(motion, self.joint, self._behind(motion, bend)))[
            :, :, rigid
        ]
        at_rest, moving = columns(self._probe(0.0)), columns(self._probe(1.0))
        rotor = self.rotor_share * (moving - at_rest)[0, self.joint, rigid]
        result[:, self.joint, rigid] += bend.ddd[:, None] * rotor
        return result

    def bend(self, state: State) -> Bend:
        """Deflection along a sampled motion, settled at its start.

        Raises:
            ValueError: If the state is symbolic.
        """
        t = state.motion(self.name).t
        zeros = np.zeros(len(t))
        whole = self.declared_inertia
        rotor, links = self.rotor_share * whole, (1 - self.rotor_share) * whole
        omega = 2 * np.pi * self.frequency
        load = self.reference.rigid(state)[self.joint] - rotor * state.ddq[self.joint] + zeros
        if self.bearing > 0:
            load = load + self.bearing * self.reference.beside_rigid(state)[self.joint]
        inertia = self.reference.inertia(state, self.joint) - rotor + zeros
        inertia = np.maximum(inertia, LEAST_INERTIA * links)
        stiffness, damping = omega**2 * links, 2 * self.damping * omega * links
        return Bend(*deflect(t, load, inertia, (stiffness, damping, self.gap / 2)))

    @property
    def declared_inertia(self) -> float:
        """M_jj of the rigid model at `posture` [kg m^2], at least a rounding error."""
        found = self.reference.inertia_at(self.posture, self.joint)
        return max(abs(found), float(np.finfo(float).tiny))

    def _behind(self, motion: Motion, bend: Bend) -> tuple[Float[ndarray, " samples"], ...]:
        motor = (getattr(motion, x)[:, self.joint] for x in ("q", "dq", "ddq"))
        return tuple(x - b for x, b in zip(motor, (bend.d, bend.dd, bend.ddd), strict=True))

    def _probe(self, acceleration: float) -> Motion:
        q = np.array([self.posture])
        ddq = np.zeros_like(q)
        ddq[0, self.joint] = acceleration
        return Motion(np.zeros(1), q, np.zeros_like(q), ddq)


@dataclass(frozen=True)
class JointElasticity(Transmission):
    """A gear, shaft or belt that gives way under load, without play."""

    name = "joint_elasticity"


@dataclass(frozen=True)
class Backlash(Transmission):
    """Play: when the load changes sides, the links cross a gap and land on the other flank."""

    name = "backlash"


@dataclass(frozen=True)
class TransmissionChange(Effect):
    """Torque as felt through a gear that yields less torque of the rigid arm, to first order.

    The coefficient is one: so a gear competes with friction column against column before
    anything is refitted. The rigid torque's slopes along the motion are asked for once and
    serve every gear that is tried.

    Attributes:
        gear: The joint and its gear.
    """

    gear: Transmission

    @property
    def name(self) -> str:  # pyright: ignore[reportIncompatibleVariableOverride]  # one for each gear
        """Of what the gear does."""
        return self.gear.name

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Share of the change, 1 by construction."""
        joint = self.gear.joint
        return (Parameter(f"{self.gear.name}_{joint + 1}", "1", joint),)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """All joint coordinates."""
        n = self.gear.reference.robot.n
        return tuple(f"{x}_{i + 1}" for x in ("q", "dq", "ddq") for i in range(n))

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """The change of every joint's torque [N m].

        Raises:
            ValueError: If the state is symbolic.
        """
        gear = self.gear
        bend = gear.bend(state)
        slopes = gear.reference.slopes(state, gear.joint)
        change = {
            i: -(by_q * bend.d + by_dq * bend.dd + by_ddq * bend.ddd)
            for i, (by_q, by_dq, by_ddq) in enumerate(slopes)
        }
        rotor = gear.rotor_share * gear.declared_inertia
        change[gear.joint] = change[gear.joint] + rotor * bend.ddd
        return [change]


@numba.njit
@no_type_check  # compiled: the tests' type checker must not wrap it
def deflect(t, load, inertia, gear):
    """Solve push(d, d') + M(t) d'' = load by the trapezoidal rule.

    The gear follows the load slowly at first, as on an arm that has been moving.

    Args:
        t: (samples,) time [s].
        load: (samples,) torque that the links need [N m].
        inertia: (samples,) M of the links, positive [kg m^2].
        gear: K [N m/rad], D on a flank [N m s/rad], half the gap [rad].

    Returns:
        (samples,) d [rad], d' and d''.
    """
    stiffness, damping, half = gear
    d, v, a = np.zeros(len(t)), np.zeros(len(t)), np.zeros(len(t))
    d[0] = load[0] / stiffness + half * np.sign(load[0])
    few = min(len(t) - 1, 10)
    if few > 0:
        v[0] = (load[few] - load[0]) / (t[few] - t[0]) / stiffness
    for k in range(1, len(t)):
        h = (t[k] - t[k - 1]) / 2
        speed = v[k - 1] + h * a[k - 1]
        place = d[k - 1] + h * (v[k - 1] + speed)
        free = load[k] / inertia[k]
        landing = place + h * h * free
        if abs(landing) <= half and half > 0.0:
            a[k] = free
        else:
            flank = half if landing > 0 else -half
            a[k] = (load[k] - damping * speed - stiffness * (place - flank)) / (
                inertia[k] + h * damping + h * h * stiffness
            )
        v[k] = speed + h * a[k]
        d[k] = place + h * h * a[k]
    return d, v, a
