"""An arm with a spring in one joint, integrated with its full nonlinear equations."""

import casadi
import numpy as np
from numpy import ndarray
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import inverse_dynamics
from oed.robot import Robot

IZZ = 9  # of a link's ten parameters


def two_mass_torque(
    robot: Robot, motion: Motion, joint: int, gear: tuple[float, float, float]
) -> ndarray:
    """Motor torque of an arm whose links hang on a spring, no approximation in the bend.

    Args:
        robot: With all inertia, the rotor's counted with its link.
        motion: Of the motors.
        joint: That has the spring.
        gear: Frequency with the motor held [Hz], damping, the rotor's share of the inertia.
    """
    frequency, damping, rotor = gear
    links = (1 - rotor) * _inertia(robot, motion, joint)
    omega = 2 * np.pi * frequency
    stiffness, damper = omega**2 * links, 2 * damping * omega * links
    inertia = rotor * _inertia(robot, motion, joint)
    bare = robot.parameters.copy()
    bare[10 * joint + IZZ] -= inertia  # exact for the first joint, which carries all others
    q, dq, ddq = (casadi.SX.sym(x, robot.n) for x in ("q", "dq", "ddq"))
    needed = inverse_dynamics(
        robot.with_parameters(bare), *(casadi.vertsplit(x) for x in (q, dq, ddq))
    )
    torque_of = casadi.Function("torque", [q, dq, ddq], [casadi.vertcat(*needed)])
    motor = CubicSpline(motion.t, np.stack([motion.q, motion.dq, motion.ddq], axis=1))

    def links_need(t: float, bend: float, rate: float, second: float) -> ndarray:
        states = motor(t).copy()
        states[:, joint] -= (bend, rate, second)
        return np.array(torque_of(*states))[:, 0]

    def rates(t: float, y: ndarray) -> list[float]:
        force = stiffness * y[0] + damper * y[1]
        without = links_need(t, y[0], y[1], 0.0)[joint]
        inertia_of_links = without - links_need(t, y[0], y[1], 1.0)[joint]
        return [y[1], (without - force) / inertia_of_links]

    still = links_need(motion.t[0], 0.0, 0.0, 0.0)[joint] / stiffness
    found = solve_ivp(rates, motion.t[[0, -1]], [still, 0.0], t_eval=motion.t, rtol=1e-6, atol=1e-9)
    torque = np.zeros_like(motion.q)
    for k, (t, y) in enumerate(zip(motion.t, found.y.T, strict=True)):
        torque[k] = links_need(t, y[0], y[1], rates(t, y)[1])
        torque[k, joint] = stiffness * y[0] + damper * y[1] + inertia * motion.ddq[k, joint]
    return torque


def _inertia(robot: Robot, motion: Motion, joint: int) -> float:
    middle = list((motion.q.min(axis=0) + motion.q.max(axis=0)) / 2)
    unit = [float(i == joint) for i in range(robot.n)]
    weightless, rest = robot.with_gravity(np.zeros(3)), [0.0] * robot.n
    return float(inverse_dynamics(weightless, middle, rest, unit)[joint])
