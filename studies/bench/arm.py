"""The simulated arm with whatever is hidden in it, and the plant that it becomes."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import State
from oed.dynamics.newton_euler import inverse_dynamics
from oed.dynamics.scalars import Scalar, tanh
from oed.experiment.friction_memory import MemoryTorque
from oed.experiment.plant import ExtraTorque, TruePlant
from oed.robot import Joint, JointLimits, Robot

PERIOD = 0.001  # [s] of control
Series = Float[ndarray, "samples joints runs"]
# (signal at every control period, period [s]) -> signal as logged
SignalChange = Callable[[Series, float], Series]
Thermometers = Callable[[Float[ndarray, " samples"]], Float[ndarray, "samples joints"]]
# deflection [rad], its rate [rad/s] -> torque [N m]
SpringLaw = Callable[[Scalar, Scalar], Scalar]


@dataclass(frozen=True)
class Transmission:
    """A joint whose motor, with encoder and friction, drives the links through a spring.

    Attributes:
        joint: Index.
        rotor: Inertia on the motor's side [kg m^2].
        law: Torque of the spring.
        bearing: Share of the joint's friction that sits behind the spring.
    """

    joint: int
    rotor: float
    law: SpringLaw
    bearing: float


@dataclass(frozen=True)
class Arm:
    """A true arm: rigid body, friction, and hidden changes of its torque and of its signals.

    Attributes:
        robot: With the true inertial parameters and gravity.
        coulomb: (n,) Coulomb friction [N m].
        viscous: (n,) viscous friction [N m s/rad].
        width: (n,) speed over which Coulomb friction turns round [rad/s]; far below any speed
            that an encoder can tell from standstill.
        slip: By joint, friction with memory that takes the place of Coulomb friction.
        extra: Hidden torques as functions of the state.
        memory: Hidden torques with states of their own.
        transmission: A flexible or loose joint, if there is one.
        torque_changes: What happens to the torque on its way to the log.
        position_changes: What happens to the position on its way to the log.
        temperature: (N, n) of the joints at N times on the arm's clock, as thermometers show it
            [degrees Celsius]; None where there are none.
        peak: (n,) largest torque of the motions at hand, for what happens near it [N m].
        session: Whether all recordings were made in one session, so that the arm's clock runs
            on from one to the next; else each begins with a cold arm.
        substeps: Runge-Kutta steps a control period that its friction needs.
    """

    robot: Robot
    coulomb: tuple[float, ...]
    viscous: tuple[float, ...]
    width: tuple[float, ...]
    slip: Mapping[int, tuple[MemoryTorque, ...]] = dataclasses.field(default_factory=dict)
    extra: tuple[ExtraTorque, ...] = ()
    memory: tuple[MemoryTorque, ...] = ()
    transmission: Transmission | None = None
    torque_changes: tuple[SignalChange, ...] = ()
    position_changes: tuple[SignalChange, ...] = ()
    temperature: Thermometers | None = None
    peak: tuple[float, ...] = ()
    session: bool = True
    substeps: int = 4

    def add(self, torque: ExtraTorque) -> Arm:
        """This arm with one more hidden torque."""
        return dataclasses.replace(self, extra=(*self.extra, torque))

    def change_torque(self, change: SignalChange) -> Arm:
        """This arm with one more change of the logged torque."""
        return dataclasses.replace(self, torque_changes=(*self.torque_changes, change))

    def change_position(self, change: SignalChange) -> Arm:
        """This arm with one more change of the logged position."""
        return dataclasses.replace(self, position_changes=(*self.position_changes, change))

    def plant(self) -> TruePlant:
        """What the simulation integrates; a transmission adds a joint, the spring, at the end."""
        robot, extra = self.robot, [self._friction, *self.extra]
        if self.transmission is not None:
            robot = _with_spring_joint(robot, self.transmission)
            extra.append(_spring_torque(self.transmission, self.robot.n))
        slipping = tuple(piece for pieces in self.slip.values() for piece in pieces)
        return TruePlant(robot, memory=(*slipping, *self.memory), extra=tuple(extra))

    def _friction(self, state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        torque = {j: self._rubbing(j, state.dq[j]) for j in range(self.robot.n)}
        if self.transmission is not None:
            j, behind = self.transmission.joint, self.robot.n
            # Friction of the link's own bearing brakes motor and spring alike.
            own = self._rubbing(j, state.dq[j] + state.dq[behind])
            share = self.transmission.bearing
            torque[j] = (1 - share) * torque[j] + share * own
            torque[behind] = share * own
        return torque

    def _rubbing(self, joint: int, speed: Scalar) -> Scalar:
        """Friction of a joint at a speed; Coulomb's part elsewhere if it has memory."""
        viscous = self.viscous[joint] * speed
        if joint in self.slip:
            return viscous
        return viscous + self.coulomb[joint] * tanh(speed / self.width[joint])


def direction(arm: Arm, state: State, joint: int) -> Scalar:
    """Sign of a joint's velocity, as sharp as its Coulomb friction is simulated."""
    return tanh(state.dq[joint] / arm.width[joint])


def least_inertia(
    robot: Robot, rng: np.random.Generator, samples: int = 200
) -> tuple[Float[ndarray, " joints"], Float[ndarray, " joints"]]:
    """Least inertia that a torque at one joint alone moves, and the mean with the others locked.

    Args:
        robot: With true parameters.
        rng: Draws positions within the limits.
        samples: Number of positions.
    """
    lower, upper = robot.limits.position.T
    matrices = mass_matrices(robot, rng.uniform(lower, upper, (samples, robot.n)))
    # The other joints give way, so that the torque accelerates less than the diagonal.
    free = 1 / np.diagonal(np.linalg.inv(matrices), axis1=1, axis2=2)
    return free.min(axis=0), np.diagonal(matrices, axis1=1, axis2=2).mean(axis=0)


def mass_matrices(
    robot: Robot, positions: Float[ndarray, "samples joints"]
) -> Float[ndarray, "samples joints joints"]:
    """Of the rigid body at many positions [kg m^2]."""
    n, rest = robot.n, robot.with_gravity(np.zeros(3))
    still = [0.0] * n
    result = np.empty((len(positions), n, n))
    for j in range(n):
        unit = [float(i == j) for i in range(n)]
        for i, torque in enumerate(inverse_dynamics(rest, list(positions.T), still, unit)):
            result[:, i, j] = torque
    return result


def _with_spring_joint(robot: Robot, transmission: Transmission) -> Robot:
    """The robot with the rotor as a body of its own; the link hangs on the spring behind it."""
    j, n = transmission.joint, robot.n
    link = robot.joints[j]
    behind = Joint(
        name=f"{link.name}_spring",
        kind=link.kind,
        parent=j,
        axis=link.axis,
        R_PJ=np.eye(3),
        p_PJ=np.zeros(3),
        link=f"{link.link}_behind_spring",
        R_LJ=link.R_LJ,
        p_LJ=link.p_LJ,
    )
    joints = [
        dataclasses.replace(joint, parent=n) if joint.parent == j else joint
        for joint in robot.joints
    ]
    parameters = robot.parameters.reshape(n, 10)
    rotor = np.zeros(10)
    rotor[[4, 7, 9]] = transmission.rotor
    rows = np.vstack([parameters, parameters[j]])
    rows[j] = rotor
    free = JointLimits.unlimited(1)
    limits = JointLimits.unlimited(n + 1).with_(
        **{
            kind: np.vstack([getattr(robot.limits, kind), getattr(free, kind)])
            for kind in ("position", "velocity", "acceleration", "torque", "jerk")
        }
    )
    return Robot(robot.name, (*joints, behind), rows.ravel(), robot.gravity, limits)


def _spring_torque(transmission: Transmission, index: int) -> ExtraTorque:
    def torque(state: State, rigid: Sequence[Scalar]) -> dict[int, Scalar]:
        del rigid
        return {index: transmission.law(state.q[index], state.dq[index])}

    return torque


def loose(deflection: Scalar, gap: float) -> Scalar:
    """How far a deflection goes beyond a gap of that width [rad]."""
    half = gap / 2
    return deflection - casadi.fmin(casadi.fmax(deflection, -half), half)
