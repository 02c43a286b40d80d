"""An arm with a spring or a loose gear in a joint, its full nonlinear equations integrated."""

from dataclasses import dataclass
from typing import Any

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
        stiffening: Of a spring K (x + stiffening x^3) [1/rad^2].
    """

    frequency: float
    damping: float
    rotor: float = 0.0
    gap: float = 0.0
    coulomb: float = 0.0
    width: float = 1.0
    viscous: float = 0.0
    stiffening: float = 0.0

    def rub(self, speed: casadi.SX) -> casadi.SX:
        """The bearing's friction [N m]."""
        return self.coulomb * casadi.tanh(speed / self.width) + self.viscous * speed


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
    q, dq, ddq = (casadi.SX.sym(x, robot.n) for x in ("q", "dq", "ddq"))
    bend, rate = casadi.SX.sym("bend"), casadi.SX.sym("rate")
    own = casadi.SX.zeros(robot.n)
    own[joint] = 1

    def links_need(second: float) -> casadi.SX:
        states = (q - bend * own, dq - rate * own, ddq - second * own)
        torque = _torque(robot.with_parameters(robot.parameters - rotor), *states)
        return torque + gear.rub(states[1][joint]) * own

    # Links that are less accelerated by the bend ask for as much less.
    without = links_need(0.0)
    less = without - links_need(1.0)
    beyond = casadi.sign(bend) * casadi.fmax(casadi.fabs(bend) - gear.gap / 2, 0.0)
    touching = 1 if gear.gap == 0 else casadi.fabs(bend) > gear.gap / 2
    push = stiffness * (beyond + gear.stiffening * beyond**3) + damper * rate * touching
    second = (without[joint] - push) / less[joint]
    torque = without - second * less + _torque(robot.with_parameters(rotor), q, dq, ddq)
    state = casadi.vertcat(q, dq, ddq, bend, rate)
    gears = casadi.Function("gears", [state], [casadi.vertcat(second, without[joint], torque)])

    motor = CubicSpline(motion.t, np.concatenate([motion.q, motion.dq, motion.ddq], axis=1))
    now, answer = np.zeros(3 * robot.n + 2), np.zeros(robot.n + 2)
    buffers: Any = gears.buffer()
    buffer, evaluate = buffers
    buffer.set_arg(0, now.data)
    buffer.set_res(0, answer.data)

    def rates(t: float, y: ndarray) -> list[float]:
        now[:-2], now[-2:] = motor(t), y
        evaluate()
        return [y[1], answer[0]]

    rates(motion.t[0], np.zeros(2))
    roots = np.roots([gear.stiffening, 0.0, 1.0, -answer[1] / stiffness])
    start = [roots[np.isreal(roots)][0].real + np.sign(answer[1]) * gear.gap / 2, 0.0]
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
    return np.array(gears(np.vstack([motor(motion.t).T, found.y])))[2:].T


def _torque(robot: Robot, q: casadi.SX, dq: casadi.SX, ddq: casadi.SX) -> casadi.SX:
    torque = inverse_dynamics(robot, *(casadi.vertsplit(x) for x in (q, dq, ddq)))
    return casadi.vertcat(*torque)


def _inertia(robot: Robot, motion: Motion, joint: int) -> float:
    middle = list((motion.q.min(axis=0) + motion.q.max(axis=0)) / 2)
    unit = [float(i == joint) for i in range(robot.n)]
    weightless, rest = robot.with_gravity(np.zeros(3)), [0.0] * robot.n
    return float(inverse_dynamics(weightless, middle, rest, unit)[joint])
