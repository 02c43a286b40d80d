"""An arm under position control, for many parameter sets or noises at once.

A control period is one function in machine code: encoder, filtered velocity, feedback, and a linearly
implicit step of the arm, in which steep friction is stable. Its parameters are inputs, so that estimators
that simulate need no new code for each trial.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.dynamics.native import Batch, native_function
from studies.estimators.arms import ContestArm, arm_of

PERIOD = 0.001  # [s] of the control
BANDWIDTH = 25.0  # [rad/s] of the position control, critically damped at the believed inertia
STICKING = (
    0.03  # [rad or m] that Coulomb friction may hold a joint off at most: stiffer where it must be
)
VELOCITY_CORNER = 2 * np.pi * 60  # [rad/s] of the controller's filtered difference
SIGN_WIDTH = 0.01  # [rad/s or m/s] over which true friction turns
STRIBECK_SPEED = 0.1  # [rad/s or m/s]
LEAST_STEP = 1e-9  # [rad or m] of an encoder that counts as exact


@dataclass(frozen=True)
class Disturbances:
    """What is not repeatable in R runs.

    Attributes:
        felt: (N, n, R) torque that the arm feels [N m or N].
        jitter: (N, n, R) of the encoders before they round [rad or m].
        step: Of the encoders [rad or m].
    """

    felt: Float[ndarray, "samples joints runs"]
    jitter: Float[ndarray, "samples joints runs"]
    step: float

    @classmethod
    def none(cls, samples: int, joints: int) -> Disturbances:
        """An arm that nothing disturbs, read exactly."""
        nothing = np.zeros((samples, joints, 1))
        return cls(nothing, nothing, LEAST_STEP)


@dataclass(frozen=True)
class Runs:
    """What the arm did, (N, n, R) each.

    Attributes:
        q: True position.
        dq: True velocity.
        ddq: True acceleration.
        measured: Position as read.
        torque: Of the drives [N m or N].
    """

    q: Float[ndarray, "samples joints runs"]
    dq: Float[ndarray, "samples joints runs"]
    ddq: Float[ndarray, "samples joints runs"]
    measured: Float[ndarray, "samples joints runs"]
    torque: Float[ndarray, "samples joints runs"]

    def motion(self, run: int, every: int) -> Motion:
        """Of one run, thinned."""
        q, dq, ddq = (x[::every, :, run] for x in (self.q, self.dq, self.ddq))
        return Motion(np.arange(len(q)) * every * PERIOD, q, dq, ddq)


def simulate(
    key: str,
    parameters: Float[ndarray, "sets base"],
    reference: Motion,
    disturbances: Disturbances,
    stribeck: Float[ndarray, " joints"] | None = None,
) -> Runs:
    """Let an arm follow a reference, with every set of parameters or every disturbance.

    Args:
        key: Of the arm.
        parameters: Base parameters; one set for all disturbances, or one disturbance for all sets.
        reference: At the control period.
        disturbances: Of the runs.
        stribeck: (n,) friction at rest beyond Coulomb friction; none if None.
    """
    arm = arm_of(key)
    n, samples = arm.robot.n, len(reference)
    count = max(len(parameters), disturbances.felt.shape[2])
    fixed = np.concatenate([parameters, np.tile(_extra(stribeck, n), (len(parameters), 1))], axis=1)
    fixed = np.broadcast_to(fixed.T, (fixed.shape[1], count))
    forward = arm.model.columns(reference)[:, :, arm.base.columns] @ arm.believed
    commanded = np.concatenate([reference.q, reference.dq, forward], axis=1)
    period = _period(key)
    state = np.zeros((4 * n, count))
    state[:n] = state[3 * n :] = reference.q[0][:, None]
    state[n : 2 * n] = state[2 * n : 3 * n] = reference.dq[0][:, None]
    step = np.full((1, count), disturbances.step)
    found = np.empty((samples, 5 * n, count))
    inputs = np.empty((4 * n + 5 * n + 1 + len(fixed), count))
    inputs[9 * n : 9 * n + 1], inputs[9 * n + 1 :] = step, fixed
    for k in range(samples):
        inputs[: 4 * n] = state
        inputs[4 * n : 7 * n] = commanded[k][:, None]
        inputs[7 * n : 8 * n] = disturbances.felt[k]
        inputs[8 * n : 9 * n] = disturbances.jitter[k]
        result = period(inputs)
        state = result[: 4 * n]
        found[k] = result[4 * n :]
    return Runs(*(found[:, i * n : (i + 1) * n] for i in range(5)))


def _extra(stribeck: Float[ndarray, " joints"] | None, joints: int) -> Float[ndarray, " joints"]:
    return np.zeros(joints) if stribeck is None else stribeck


@cache
def _period(key: str) -> Batch:
    """The control period in machine code, or as CasADi evaluates it where there is no compiler."""
    function = _symbolic_period(arm_of(key))
    compiled = native_function([function])
    if compiled is not None:
        return compiled[0]
    return lambda values: np.array(function(values))


def _symbolic_period(arm: ContestArm) -> casadi.Function:
    n, b = arm.robot.n, len(arm.base)
    x, w = casadi.SX.sym("x", 4 * n), casadi.SX.sym("w", 5 * n + 1)
    theta, extra = casadi.SX.sym("theta", b), casadi.SX.sym("extra", n)
    q, dq, filtered, old = casadi.vertsplit(x, n)
    q_d, dq_d, forward, felt, jitter, step = casadi.vertsplit(
        w, [0, n, 2 * n, 3 * n, 4 * n, 5 * n, 5 * n + 1]
    )
    inertia = _own_inertia(arm)
    measured = (casadi.floor((q + jitter) / step) + 0.5) * step
    share = 1 - np.exp(-VELOCITY_CORNER * PERIOD)
    velocity = filtered + share * ((measured - old) / PERIOD - filtered)
    stiffness = np.maximum(inertia * BANDWIDTH**2, arm.coulomb / STICKING)
    torque = forward + casadi.DM(stiffness) * (q_d - measured)
    torque += casadi.DM(2 * np.sqrt(stiffness * inertia)) * (dq_d - velocity)
    ddq = casadi.SX.sym("ddq", n)
    columns = arm.model.symbolic_columns(q, dq, ddq, SIGN_WIDTH)[:, arm.base.columns.tolist()]
    needed = columns @ theta
    needed += extra * casadi.tanh(dq / SIGN_WIDTH) * casadi.exp(-((dq / STRIBECK_SPEED) ** 2))
    mass = casadi.jacobian(needed, ddq)
    rest = casadi.substitute(needed, ddq, casadi.DM.zeros(n))
    # The diagonal of the damping, taken at the end of the step: friction turns its sign within one.
    implicit = mass + PERIOD * casadi.diag(casadi.diag(casadi.jacobian(rest, dq)))
    D, LT, p = casadi.ldl(implicit)
    found = casadi.ldl_solve(torque + felt - rest, D, LT, p)
    after = dq + PERIOD * found
    nexts = casadi.vertcat(q + PERIOD * after, after, velocity, measured)
    output = casadi.vertcat(nexts, q, dq, found, measured, torque)
    everything = casadi.vertcat(x, w, theta, extra)
    return casadi.Function("period", [everything], [output], {"cse": True})


def _own_inertia(arm: ContestArm) -> Float[ndarray, " joints"]:
    """(n,) believed inertia of each joint for itself, in the middle of its range."""
    middle = arm.robot.limits.position.mean(axis=1)
    still = np.zeros((1, arm.robot.n))

    def torque(ddq: Float[ndarray, "1 joints"]) -> Float[ndarray, " joints"]:
        motion = Motion(np.zeros(1), middle[None], still, ddq)
        return (arm.model.columns(motion)[:, :, arm.base.columns] @ arm.believed)[0]

    rest = torque(still)
    return np.array([torque(unit[None])[j] - rest[j] for j, unit in enumerate(np.eye(arm.robot.n))])
