"""An arm with a spring or a loose gear in a joint, its full nonlinear equations integrated."""

from dataclasses import dataclass

import casadi
import numpy as np
from numpy import ndarray
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import inverse_dynamics
from oed.robot import Robot

IZZ = 9  # of a link's ten parameters: both joints of the arms used here turn about z
LONGEST_STEP = 1e-3  # [s]: a gap must not be stepped over


@dataclass(frozen=True)
class Gear:
    """What lies between motor and links.

    Attributes:
        frequency: With the motor held [Hz].
        damping: Of it, on a flank.
        rotor: Share of the inertia.
        gap: Between the flanks [rad].
        coulomb: Friction of the links' own bearing [N m].
        width: Of its sign [rad/s].
        viscous: Friction of the links' own bearing [N m s/rad].
    """

    frequency: float
    damping: float
    rotor: float = 0.0
    gap: float = 0.0
    coulomb: float = 0.0
    width: float = 1.0
    viscous: float = 0.0

    def rub(self, speed: float) -> float:
        """The bearing's friction [N m]."""
        return self.coulomb * float(np.tanh(speed / self.width)) + self.viscous * speed


def two_mass_torque(robot: Robot, motion: Motion, joint: int, gear: Gear) -> ndarray:
    """Motor torque, no approximation in the bend; friction of the bearing included.

    Args:
        robot: With all inertia, the rotor's counted with its link.
        motion: Of the motors.
        joint: That has the gear.
        gear: What lies there.
    """
    whole = _inertia(robot, motion, joint)
    links = (1 - gear.rotor) * whole
    omega = 2 * np.pi * gear.frequency
    stiffness, damper = omega**2 * links, 2 * gear.damping * omega * links
    rotor = np.zeros_like(robot.parameters)
    rotor[10 * joint + IZZ] = gear.rotor * whole
    torque_of = _torque(robot.with_parameters(robot.parameters - rotor))
    rotor_of = _torque(robot.with_parameters(rotor))
    motor = CubicSpline(motion.t, np.stack([motion.q, motion.dq, motion.ddq], axis=1))

    def push(bend: float, rate: float) -> float:
        beyond = bend - float(np.clip(bend, -gear.gap / 2, gear.gap / 2))
        touching = gear.gap == 0 or abs(bend) > gear.gap / 2
        return stiffness * beyond + damper * rate * touching

    def links_need(t: float, bend: float, rate: float, second: float) -> ndarray:
        states = motor(t).copy()
        states[:, joint] -= (bend, rate, second)
        torque = np.array(torque_of(*states))[:, 0]
        torque[joint] += gear.rub(states[1, joint])
        return torque

    def rates(t: float, y: ndarray) -> list[float]:
        without = links_need(t, y[0], y[1], 0.0)[joint]
        inertia_of_links = without - links_need(t, y[0], y[1], 1.0)[joint]
        return [y[1], (without - push(y[0], y[1])) / inertia_of_links]

    need = links_need(motion.t[0], 0.0, 0.0, 0.0)[joint]
    start = [need / stiffness + np.sign(need) * gear.gap / 2, 0.0]
    found = solve_ivp(
        rates,
        motion.t[[0, -1]],
        start,
        method="LSODA",
        t_eval=motion.t,
        rtol=1e-6,
        atol=1e-9,
        max_step=LONGEST_STEP if gear.gap > 0 else np.inf,
    )
    torque = np.zeros_like(motion.q)
    for k, (t, y) in enumerate(zip(motion.t, found.y.T, strict=True)):
        torque[k] = links_need(t, y[0], y[1], rates(t, y)[1])
        torque[k] += np.array(rotor_of(*motor(t)))[:, 0]
    return torque


def _torque(robot: Robot) -> casadi.Function:
    q, dq, ddq = (casadi.SX.sym(x, robot.n) for x in ("q", "dq", "ddq"))
    torque = inverse_dynamics(robot, *(casadi.vertsplit(x) for x in (q, dq, ddq)))
    return casadi.Function("torque", [q, dq, ddq], [casadi.vertcat(*torque)])


def _inertia(robot: Robot, motion: Motion, joint: int) -> float:
    middle = list((motion.q.min(axis=0) + motion.q.max(axis=0)) / 2)
    unit = [float(i == joint) for i in range(robot.n)]
    weightless, rest = robot.with_gravity(np.zeros(3)), [0.0] * robot.n
    return float(inverse_dynamics(weightless, middle, rest, unit)[joint])
