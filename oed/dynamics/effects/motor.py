"""What a drive adds to its joint, and to a joint that it is geared to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from oed.dynamics.effects.effect import Effect, Parameter, Part, State
from oed.dynamics.effects.on_reference import FollowsTorque
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.scalars import Scalar, mul, total


@dataclass(frozen=True)
class RotorInertia(Effect):
    """Inertia of the rotor seen at the joint, I_a ddq_j, with I_a = N^2 J for gear ratio N.

    The rotor's gyroscopic torque is neglected, as is usual for geared arms
    (Khalil and Dombre 2002, section 9.4).
    """

    joint: int
    name = "rotor_inertia"
    joint_term = "armature"
    dissipates = True
    part = "inertia"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """I_a."""
        return (Parameter(f"Ia_{self.joint + 1}", "kg m^2", self.joint),)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's acceleration."""
        return (f"ddq_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """ddq_j."""
        return [{self.joint: state.ddq[self.joint]}]


@dataclass(frozen=True)
class MotorCoupling(Effect):
    """A motor whose speed combines several joints, such as the last one of a wrist.

    With motor speed u = sum_j r_j dq_j (in units of the gear ratio), its inertia, viscous
    and Coulomb friction act on joint j as r_j (I_a u' + F_v u + F_c sgn u). On the Staubli
    TX40 motor 6 turns with dq_5 + dq_6 (Gautier and Khalil's model of the wrist).

    Attributes:
        joints: Indices of the joints that the motor turns with.
        ratios: r_j of each.
        width: Velocity over which the sign turns [rad/s]; 0 for the exact sign.
    """

    joints: tuple[int, ...]
    ratios: tuple[float, ...]
    width: float = 0.0
    name = "motor_coupling"
    dissipates = True

    def __post_init__(self) -> None:
        if len(self.joints) != len(self.ratios) or len(self.joints) < 2:
            raise ValueError(
                f"{self.joints=} and {self.ratios=}: need one ratio a joint, two or more"
            )

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Inertia, viscous and Coulomb friction of the coupled motor."""
        tag = "".join(str(joint + 1) for joint in self.joints)
        named = (("Ia", "kg m^2"), ("Fv", "N m s/rad"), ("Fc", "N m"))
        return tuple(Parameter(f"{symbol}_m{tag}", unit, self.joints[-1]) for symbol, unit in named)

    @property
    def parts(self) -> tuple[Part, ...]:
        """An inertia, and friction."""
        return ("inertia", "friction", "friction")

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Velocities and accelerations of the coupled joints."""
        return tuple(f"{x}_{joint + 1}" for x in ("dq", "ddq") for joint in self.joints)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """Inertia, viscous and Coulomb columns, each on every coupled joint."""
        speed = self._motor(state.dq)
        signals = (self._motor(state.ddq), speed, state.sign(speed, self.width))
        pairs = list(zip(self.joints, self.ratios, strict=True))
        return [{joint: mul(ratio, signal) for joint, ratio in pairs} for signal in signals]

    def _motor(self, rates: Sequence[Scalar]) -> Scalar:
        return total(
            [
                mul(ratio, rates[joint])
                for joint, ratio in zip(self.joints, self.ratios, strict=True)
            ]
        )


@dataclass(frozen=True)
class CrossCoupling(Effect):
    """I_x ddq_i + F_xv dq_i + F_xc sgn(dq_i) on joint j, and I_x ddq_j on joint i.

    For a drive whose friction is recorded on joint j but that also turns when joint i does
    (Janot, Vandanjon and Gautier 2014, the TX40's wrist). Its inertia couples both joints
    alike, since their kinetic energy has one product I_x dq_i dq_j. Where the log has torques of
    motors and not of joints, joint j's row alone shows it.

    Attributes:
        joint: j, whose torque it is.
        other: i, whose motion it follows.
        width: Velocity over which the sign turns [rad/s]; 0 for the exact sign.
        mutual: Whether joint i's row has its share of the inertia.
    """

    joint: int
    other: int
    width: float = 0.0
    mutual: bool = True
    name = "motor_coupling"

    def __post_init__(self) -> None:
        if self.joint == self.other:
            raise ValueError(f"{self.joint=} cannot be coupled to itself")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """I_x, F_xv and F_xc."""
        tag = f"x{self.joint + 1}{self.other + 1}"
        named = (("Ia", "kg m^2"), ("Fv", "N m s/rad"), ("Fc", "N m"))
        return tuple(Parameter(f"{symbol}_{tag}", unit, self.joint) for symbol, unit in named)

    @property
    def parts(self) -> tuple[Part, ...]:
        """An inertia, and friction."""
        return ("inertia", "friction", "friction")

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Velocity of the other joint, accelerations of both."""
        j, i = self.joint + 1, self.other + 1
        return (f"dq_{i}", f"ddq_{i}", *((f"ddq_{j}",) if self.mutual else ()))

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """ddq_i, dq_i and sgn(dq_i) on joint j, and ddq_j on joint i."""
        j, i = self.joint, self.other
        speed = state.dq[i]
        inertia = {j: state.ddq[i], **({i: state.ddq[j]} if self.mutual else {})}
        return [inertia, {j: speed}, {j: state.sign(speed, self.width)}]


@dataclass(frozen=True)
class MixedTorque(FollowsTorque):
    """s tau_i on joint j: motors' torques that stand for the joints' without their coupling undone.

    Where motor i turns with dq_i + r dq_j, as in a wrist, virtual work gives motor j the torque
    tau_j - r tau_i: what is recorded there holds a share of all that joint i needs.

    Attributes:
        joint: j, whose recorded torque it is.
        other: i, whose torque it holds.
        reference: Predicts that.
    """

    joint: int
    other: int
    reference: ReferenceTorque
    name = "motor_coupling"

    def __post_init__(self) -> None:
        if self.joint == self.other:
            raise ValueError(f"{self.joint=} cannot be coupled to itself")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The share s."""
        return (Parameter(f"share_x{self.joint + 1}{self.other + 1}", "1", self.joint),)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The other joint's torque."""
        return (f"tau_{self.other + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """tau_i on joint j."""
        return [{self.joint: self.reference.total(state)[self.other]}]
