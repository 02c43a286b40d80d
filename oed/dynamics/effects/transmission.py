"""A joint that yields: its links hang on a spring behind motor and encoder, with or without play."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.effects.measurement_effect import MeasurementEffect
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.motion import Motion, with_joint
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
class Rubbing:
    """Friction as a function of speed; none by default.

    Attributes:
        coulomb: [N m], not negative.
        width: Speed over which its sign turns, positive [rad/s].
        viscous: [N m s/rad], not negative.
    """

    coulomb: float = 0.0
    width: float = 1.0
    viscous: float = 0.0

    def torque(self, speed: Float[ndarray, " samples"]) -> Float[ndarray, " samples"]:
        """At some speeds [N m]."""
        return self.coulomb * np.tanh(speed / self.width) + self.viscous * speed


@dataclass(frozen=True)
class Transmission(MeasurementEffect):
    """The rigid body at the links' position q - delta, delta what a joint's gear gives way.

    The two masses of Spong (1987) on the dead zone of Nordin and Gutman (2002), the position
    measured at the motor. On a flank the gear pushes with K (x + k x^3) + D delta', x = delta -+
    gap/2 and k for springs that stiffen as strain-wave gears do (Tuttle and Seering 1996), within
    the gap not at all; it pushes what the links need, H(q - delta)_j less the rotor's own torque R
    and with the friction of their own bearing. With the inertia M_jj of the rigid model, in
    which the rotor is counted with the link, to first order in delta

        push(delta, delta') + (M_jj - J) delta'' = H(q)_j - R(q)_j + bearing f_j(q' - delta'),

    f the joint's friction, solved in time along the recording. *All* joints then feel the links
    where they are; the rotor, a body on the joint's axis, does not give way, and adds what
    J delta'' is to it. Coulomb and viscous friction behind the gear brake the links' own motion:
    while these cross a gap they may stand still, and the blow at its end depends on that.

    Attributes:
        joint: Index of the joint.
        frequency: Of small swings of the links on the spring, motor held, at `posture` [Hz].
        damping: D / (2 sqrt(K M)), M of the links at `posture`.
        rotor_share: J / M_jj at `posture`, below 1.
        gap: Play between the flanks [rad or m].
        bearing: Share of the joint's friction that sits behind the gear.
        posture: (n,) position where these are declared [rad or m].
        reference: Gives the load.
        rubbing: Coulomb and viscous friction behind the gear, part of what `reference` has
            beside the rigid body: here the links' speed decides.
        stiffening: k [1/rad^2 or 1/m^2].
    """

    joint: int
    frequency: float
    damping: float
    rotor_share: float
    gap: float
    bearing: float
    posture: tuple[float, ...]
    reference: ReferenceTorque
    rubbing: Rubbing = Rubbing()
    stiffening: float = 0.0
    name = "transmission"
    made_of = (Rubbing,)
    not_simulated = "the links behind the gear move on their own, and need a joint of their own"

    def __post_init__(self) -> None:
        if self.frequency <= 0 or self.damping <= 0:
            raise ValueError(f"{self.frequency=} and {self.damping=} must be positive")
        if not 0 <= self.rotor_share < 1:
            raise ValueError(f"{self.rotor_share=} must be at least 0 and below 1")
        if self.gap < 0 or self.stiffening < 0 or not 0 <= self.bearing <= 1:
            raise ValueError(
                f"{self.gap=} and {self.stiffening=} must not be negative, {self.bearing=} in 0 to 1"
            )

    def through(
        self,
        columns: Callable[[Motion], Float[ndarray, "samples joints columns"]],
        motion: Motion,
        rigid: Bool[ndarray, " columns"],
    ) -> Float[ndarray, "samples joints columns"]:
        """The columns with the rigid body where the links are, and friction behind the gear at their speed."""
        result = np.array(columns(motion))
        if self.bearing == 0 and not rigid.any():
            return result
        state = State.along(motion)
        bend = self.bend(state)
        behind = columns(with_joint(motion, self.joint, self._behind(motion, bend)))
        result[:, :, rigid] = behind[:, :, rigid]
        step = behind[:, self.joint, ~rigid] - result[:, self.joint, ~rigid]
        result[:, self.joint, ~rigid] += self.bearing * step
        if not rigid.any():
            return result
        at_rest, moving = columns(self._probe(0.0)), columns(self._probe(1.0))
        rotor = self.rotor_share * (moving - at_rest)[0, self.joint, rigid]
        for joint, moved in enumerate(self.reference.rotor_inertia(state, self.joint)):
            result[:, joint, rigid] += (bend.ddd * moved)[:, None] * rotor
        return result

    @property
    def offline(self) -> str:
        """What its links do is solved along whole recordings."""
        return "how far the gear gives way is solved along a whole recording"

    def bend(self, state: State) -> Bend:
        """Deflection along a sampled motion, settled at its start.

        Raises:
            ValueError: If the state is symbolic.
        """
        from oed.dynamics.effects.deflection import deflect  # noqa: PLC0415  # loads Numba

        t = state.motion(self.name).t
        zeros = np.zeros(len(t))
        rotor, links = self.rotor_inertia, self.declared_inertia - self.rotor_inertia
        speed = state.dq[self.joint] + zeros
        rigid, unit = self.reference.expected(state, self.joint)
        load = rigid - rotor * unit + zeros
        if self.bearing > 0:
            other = self.reference.beside_rigid(state)[self.joint]
            load = load + self.bearing * other - self.rubbing.torque(speed)
        inertia = self.reference.inertia(state, self.joint) - rotor + zeros
        inertia = np.maximum(inertia, LEAST_INERTIA * links)
        damping = 2 * self.damping * self.stiffness / (2 * np.pi * self.frequency)
        gear = (self.stiffness, damping, self.gap / 2, self.stiffening)
        brake = (speed, self.rubbing.coulomb, self.rubbing.width, self.rubbing.viscous)
        return Bend(*deflect(t, load, inertia, gear, brake))

    @property
    def declared_inertia(self) -> float:
        """M_jj of the rigid model at `posture` [kg m^2], at least a rounding error."""
        found = self.reference.inertia_at(self.posture, self.joint)
        return max(abs(found), float(np.finfo(float).tiny))

    @property
    def rotor_inertia(self) -> float:
        """J [kg m^2]."""
        return self.rotor_share * self.declared_inertia

    @property
    def stiffness(self) -> float:
        """K of a small deflection [N m/rad]."""
        links = self.declared_inertia - self.rotor_inertia
        return (2 * np.pi * self.frequency) ** 2 * links

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
    made_of = (Rubbing,)
    offline = "it is worked out along whole recordings"

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
        if gear.rotor_share > 0:
            for i, moved in enumerate(gear.reference.rotor_inertia(state, gear.joint)):
                change[i] = change[i] + gear.rotor_inertia * moved * bend.ddd
        rub, speed = gear.rubbing.torque, state.dq[gear.joint]
        change[gear.joint] = change[gear.joint] + rub(speed - bend.dd) - rub(speed)
        return [change]
