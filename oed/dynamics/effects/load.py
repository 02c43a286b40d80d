"""Effects that grow with the torque: friction under load, and a motor near its limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from oed.dynamics.effects.effect import Parameter, State
from oed.dynamics.effects.on_reference import FollowsTorque
from oed.dynamics.effects.parameter import Demand
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.scalars import Scalar, add, is_zero, magnitude, mul, power, sign

MOST_LOSS = 0.6  # of the load: a gear that hardly turns back
MOST_LOST = 0.6  # of the peak torque, by a motor deep in saturation


@dataclass(frozen=True)
class LoadFriction(FollowsTorque):
    """mu |tau_load| sgn(dq_j), friction of gears and bearings under load, to second order if asked.

    Gogoussis and Donath 1988; Hamon, Gautier and Garrec 2010; Bittencourt and Gunnarsson
    2012. The load is tau_rigid + share * (the rest of the modelled torque): the torque at the
    gear's output for share 0, at its input for 1. A negative share is that of the inertial torque
    that it lacks: the weight alone for -1, which is what static tests see. Where teeth and rollers
    are pressed harder than in proportion, mu_more |tau_load / tau_peak| |tau_load| sgn(dq_j) adds to it.
    A gear that turns back harder or more easily than it drives has mu where it drives the load and
    mu_driven where the load drives it.

    Attributes:
        joint: Index of the joint.
        reference: Gives the load.
        share: Of friction in the load, 0 to 1; of what the load lacks of inertial torque, 0 to -1.
        width: Velocity over which the sign turns [rad/s]; 0 for the exact sign.
        peak: tau_peak [N m] of the term of second order; None without that term.
        by_power: Whether it has one coefficient where power goes to the load and another where
            it comes back.
    """

    joint: int
    reference: ReferenceTorque
    share: float = 0.0
    width: float = 0.0
    peak: float | None = None
    by_power: bool = False
    name = "load_dependent_friction"

    def __post_init__(self) -> None:
        if self.peak is not None and self.peak <= 0:
            raise ValueError(f"{self.peak=} must be positive")
        if self.peak is not None and self.by_power:
            raise ValueError(
                f"{self.peak=} belongs to a formula that does not ask for the power's way"
            )

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The coefficient mu, and mu_more or mu_driven."""
        names = ["mu"]
        if self.peak is not None:
            names.append("mu_more")
        elif self.by_power:
            names.append("mu_driven")
        return tuple(Parameter(f"{name}_{self.joint + 1}", "1", self.joint) for name in names)

    @property
    def demands(self) -> tuple[Demand, ...]:
        """Some loss at the peak and at half of it, or each way, and no more than a gear can have."""
        names = " and ".join(p.name for p in self.parameters)
        if self.by_power:
            rows = ((1.0, 0.0), (0.0, 1.0))
        elif self.peak is not None:
            rows = ((1.0, 1.0), (1.0, 0.5))
        else:
            rows = ((1.0,),)
        least = [Demand(row, 0.0, f"loss by {names} >= 0") for row in rows]
        most = [
            Demand(tuple(-x for x in row), -MOST_LOSS, f"loss by {names} <= {MOST_LOSS:g}")
            for row in rows
        ]
        return (*least, *most)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's torque and the sign of its velocity."""
        return (f"tau_{self.joint + 1}", f"dq_{self.joint + 1}")

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """|tau_load| sgn(dq_j), and that times |tau_load| / tau_peak; or its two ways."""
        load = self.reference.rigid(state)[self.joint]
        if self.share > 0:
            rest = self.reference.beside_rigid(state)[self.joint]
            load = add(load, mul(self.share, rest))
        elif self.share < 0:
            weight = self.reference.weight(state)[self.joint]
            load = add(mul(1 + self.share, load), mul(-self.share, weight))
        direction = state.sign(state.dq[self.joint], self.width)
        friction = mul(magnitude(load), direction)
        if self.by_power:  # as the sign turns, half of the time one way and half the other
            towards = mul(load, mul(direction, direction))
            back = mul(-1.0, towards)
            return [{self.joint: mul(0.5, add(friction, way))} for way in (towards, back)]
        if self.peak is None:
            return [{self.joint: friction}]
        more = mul(magnitude(load) / self.peak, friction)
        return [{self.joint: friction}, {self.joint: more}]


@dataclass(frozen=True)
class TorqueSaturation(FollowsTorque):
    """-tau_s |tau/tau_peak|^m sgn(tau): torque constant that falls at high current.

    Iron saturates: the torque constant falls with the square of current, which is m = 3
    (Hendershot and Miller 2010, section 5); a drive that limits falls more abruptly. The
    torque computed from current is then below the model's where that is large. Deep in
    saturation one power is no longer enough: the series of a tanh, or of its inverse where the
    current is what rises, goes on with the power 2 m - 1. What a limit cuts begins at a torque and
    goes on in proportion: -tau_s (1 + m (|tau/tau_peak| - 1))_+ sgn(tau), as steep at the peak as
    the power.

    Attributes:
        joint: Index of the joint.
        reference: Gives the torque.
        peak: tau_peak [N m], at which tau_s is lost.
        exponent: m.
        form: "power"; "series", whose next term has its own coefficient; or "limit".
    """

    joint: int
    reference: ReferenceTorque
    peak: float
    exponent: float = 3.0
    form: Literal["power", "series", "limit"] = "power"
    name = "torque_saturation"

    def __post_init__(self) -> None:
        if self.peak <= 0 or self.exponent <= 1:
            raise ValueError(f"{self.peak=} must be positive and {self.exponent=} above 1")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """tau_s, the torque lost at the peak, of every term."""
        names = ("saturation", *(("saturation_deep",) if self.form == "series" else ()))
        return tuple(Parameter(f"{name}_{self.joint + 1}", "N m", self.joint) for name in names)

    @property
    def demands(self) -> tuple[Demand, ...]:
        """The torque does not turn at its peak."""
        bound, ones = -MOST_LOST * self.peak, (1.0,) * len(self.parameters)
        words = f"change by {self.parameters[0].name} within {-bound:.3g} N m"
        return (Demand(ones, bound, words), Demand(tuple(-x for x in ones), bound, words))

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The joint's torque."""
        return (f"tau_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """-|tau/tau_peak|^m sgn(tau), and the same of 2 m - 1; or what lies beyond the limit."""
        torque = self.reference.total(state)[self.joint]
        if is_zero(torque):
            return [{} for _ in self.parameters]
        share, towards = magnitude(torque) / self.peak, sign(torque)
        if self.form == "limit":
            beyond = 1 + self.exponent * (share - 1)
            return [{self.joint: -0.5 * (beyond + magnitude(beyond)) * towards}]
        powers = series_powers(self.exponent)[: len(self.parameters)]
        return [{self.joint: -power(share, m) * towards} for m in powers]


def series_powers(exponent: float) -> tuple[float, float]:
    """Powers of a saturation's first two terms: 3 and 5 of a tanh and of its inverse."""
    return exponent, 2 * exponent - 1
