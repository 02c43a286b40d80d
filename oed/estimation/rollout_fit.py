"""Output-error refinement: parameters with which a simulation stays near the measured motion.

Inverse dynamics fits torques at given accelerations; this fits positions after half a second of simulation.
With the right class of model both find the same parameters up to noise, so what lies between them, in
units of the first fit's deviations, tells whether the class is right.

The first fit is the prior: parameters are theta_0 + A z with A A' its covariance, and z costs z'z. A window
of simulation counts as one observation a joint, as its errors are all of one origin, and its
deviation is what the first fit misses there. Multiple shooting: the state at every node is an unknown
and the steps between are constraints (Bock and Plitt 1984). A step is Radau's of two stages, of
third order and without ringing where a joint sticks (Hairer and Wanner 1996, IV.5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.integrate import cumulative_trapezoid

from oed.dynamics.effects import State, with_columns
from oed.dynamics.online import without_offline
from oed.dynamics.torque_model import TorqueModel
from oed.errors import NoUsableResult
from oed.estimation import rollout
from oed.estimation.rollout import ImplicitArm, Track
from oed.estimation.symbolic_bodies import possible_bodies

# [s] of a window: longer ones of an arm near an upright pose tell its start, not its model.
LENGTH = 0.5
STEP = 0.025  # [s]: third order keeps a motion of a few hertz to a ten thousandth
MOST_WINDOWS = 24  # of all recordings: a minute of work for six joints
STAGES = (1 / 3, 1.0)  # of Radau IIA, in steps
WEIGHTS = np.array([[5 / 12, -1 / 12], [3 / 4, 1 / 4]])  # of its accelerations
# Of a sign's turn at least [rad/s]: below what a simulation in MuJoCo or Drake has; Newton's steps need it.
SIGN_WIDTH = 0.02
SECONDS = 120.0  # of CPU time: dry friction has corners, about which the solver goes on for long
ITERATIONS = 200  # of IPOPT: the time ends before, on six joints after some 30
TOLERANCE = 1e-6  # of IPOPT, far below a deviation of the first fit, in which it counts


@dataclass(frozen=True)
class RolloutFit:
    """Parameters with which simulations stay near the measured motion.

    Attributes:
        parameters: (p,) of all columns.
        shift: (r,) from the first fit, in its standard deviations along its main directions.
        windows: How many were fitted.
        status: What the solver says. What it did not bring to its end is a proposal too: simulations
            of recordings that were not fitted have to judge it.
    """

    parameters: Float[ndarray, " p"]
    shift: Float[ndarray, " r"]
    windows: int
    status: str

    @property
    def distance(self) -> float:
        """Squared, of both fits [deviations of the first].

        With the right class of model at most chi-squared with r degrees of freedom: the prior
        keeps the second fit near the first.
        """
        return float(self.shift @ self.shift)


@dataclass(frozen=True)
class Windows:
    """Measured motion at the nodes of K windows of S steps, and the torque at their stages.

    Attributes:
        q: (K, S + 1, n) [rad or m].
        dq: (K, S + 1, n).
        ddq: (K, S, 2, n) at the stages.
        tau: (K, S, 2, n) torque that acts there [N m or N].
        memory: (K, m) what effects remember at the first node.
        deviation: (n,) root mean square of what the first fit misses of q [rad or m].
    """

    q: Float[ndarray, "windows nodes joints"]
    dq: Float[ndarray, "windows nodes joints"]
    ddq: Float[ndarray, "windows steps 2 joints"]
    tau: Float[ndarray, "windows steps 2 joints"]
    memory: Float[ndarray, "windows kept"]
    deviation: Float[ndarray, " joints"]


def refine_by_rollout(
    model: TorqueModel,
    parameters: Float[ndarray, " p"],
    half: Float[ndarray, "p r"],
    tracks: Sequence[Track],
    *,
    weights: Float[ndarray, "k p"],
    bounds: Float[ndarray, " k"],
) -> RolloutFit:
    """Fit simulations of windows to the measured motion.

    Args:
        model: The torque model.
        parameters: Of the first fit, all columns; of bodies that exist.
        half: A with A A' the covariance of these.
        tracks: Recordings to be fitted.
        weights: What effects ask: weights @ parameters >= bounds.
        bounds: Of these.

    Raises:
        NoUsableResult: If no window can be simulated.
        NotSimulated: If the mass matrix is not positive definite where the arm was.
    """
    windows = cut(model, parameters, tracks)
    possible = possible_bodies(model.robot.n, parameters, half, weights, bounds)
    shift, status = _solve(_step(model, parameters, half), windows, possible)
    return RolloutFit(parameters + half @ shift, shift, len(windows.q), status)


def cut(model: TorqueModel, parameters: Float[ndarray, " p"], tracks: Sequence[Track]) -> Windows:
    """Windows of recordings that the first fit follows to their end.

    Raises:
        NoUsableResult: If there are none.
    """
    arm = ImplicitArm.of(model, parameters, rollout.STEP)
    steps = round(LENGTH / STEP)
    nodes = STEP * np.arange(steps + 1)
    stages = (nodes[:-1, None] + STEP * np.array(STAGES)).ravel()
    found, missed = [], []
    for recorded in tracks:
        arm.require_inertia(recorded.motion)
        track = recorded.at_the_arm(model)
        for start in track.starts(LENGTH, max(1, MOST_WINDOWS // len(tracks))):
            t = track.motion.t
            now = t[start]
            q, dq = (_at(now + nodes, t, x) for x in (track.motion.q, track.motion.dq))
            ddq, tau = _at(now + stages, t, track.motion.ddq), _mean(now + stages, track)
            off = arm.follow(track, int(start), nodes[1:].tolist()) - q[1:]
            if np.isfinite(off).all():
                shape = (steps, len(STAGES), -1)
                memory = np.array(arm.begin(q[0], dq[0], track.motion.ddq[start])).ravel()
                found.append((q, dq, ddq.reshape(shape), tau.reshape(shape), memory))
                missed.append(off)
    if not found:
        raise NoUsableResult(
            f"no window of {LENGTH:g} s of the estimation recordings can be simulated to its end"
        )
    parts = (np.array(x) for x in zip(*found, strict=True))
    return Windows(*parts, np.sqrt(np.mean(np.square(missed), axis=(0, 1))))  # pyright: ignore[reportCallIssue]


def _at(
    when: Float[ndarray, " k"], t: Float[ndarray, " samples"], x: Float[ndarray, "samples joints"]
) -> Float[ndarray, "k joints"]:
    return np.stack([np.interp(when, t, own) for own in x.T], axis=1)


def _mean(when: Float[ndarray, " k"], track: Track) -> Float[ndarray, "k joints"]:
    """Torque about some instants, as the mean over a step: between them it may have gone anywhere."""
    impulse = cumulative_trapezoid(track.tau, track.t, axis=0, initial=0.0)
    ends = (_at(when + side, track.t, impulse) for side in (STEP / 2, -STEP / 2))
    return np.subtract(*ends) / STEP


def _step(
    model: TorqueModel, parameters: Float[ndarray, " p"], half: Float[ndarray, "p r"]
) -> casadi.Function:
    """(q, dq, accelerations at the stages, memory, z, applied) -> q, dq, memory after, missing torque."""
    kept, _ = without_offline(model, parameters)
    places = [place for e, place in with_columns(model.effects) if not e.offline]
    columns = np.concatenate([np.arange(len(parameters))[place] for place in places])
    n, r = model.robot.n, half.shape[1]
    q, dq = casadi.SX.sym("q", n), casadi.SX.sym("dq", n)
    both, applied = casadi.SX.sym("a", 2 * n), casadi.SX.sym("applied", 2 * n)
    a = casadi.reshape(both, n, 2)
    z = casadi.SX.sym("z", r)
    theta = casadi.DM(parameters[columns]) + casadi.mtimes(casadi.DM(half[columns]), z)
    memory = casadi.SX.sym("memory", sum(len(effect.keeps) for effect in kept.effects))
    moving = casadi.repmat(dq, 1, 2) + STEP * casadi.mtimes(a, casadi.DM(WEIGHTS.T))
    there = casadi.repmat(q, 1, 2) + STEP * casadi.mtimes(moving, casadi.DM(WEIGHTS.T))
    missing, after = [], []
    for k in range(len(STAGES)):
        state = State(0.0, *(casadi.vertsplit(x[:, k]) for x in (there, moving, a)), SIGN_WIDTH)  # pyright: ignore[reportArgumentType, reportCallIssue]
        torque, after = _torque(kept, theta, state, memory)
        missing.append(applied[k * n : (k + 1) * n] - torque)
    return casadi.Function(
        "step",
        [q, dq, both, memory, z, applied],
        [
            there[:, 1],
            moving[:, 1],
            casadi.vertcat(casadi.SX(0, 1), *after),
            casadi.vertcat(*missing),
        ],
        {"cse": True},
    )


def _torque(
    model: TorqueModel, theta: casadi.SX, state: State, memory: casadi.SX
) -> tuple[casadi.SX, list]:
    """Torque of symbolic parameters, by the columns, and what is remembered after the step."""
    torque, following, start = casadi.SX(model.robot.n, 1), [], 0
    for effect, place in with_columns(model.effects):
        stop = start + len(effect.keeps)
        own = [memory[k] for k in range(start, stop)]
        columns, kept = effect.recall(state, own, STEP)
        for index, column in zip(range(place.start, place.stop), columns, strict=True):
            for joint, value in column.items():
                torque[joint] += theta[index] * value
        following += kept
        start = stop
    return torque, following


def _solve(
    step: casadi.Function, windows: Windows, possible: casadi.Function
) -> tuple[Float[ndarray, " r"], str]:
    """Shift, and what the solver says."""
    K, nodes, n = windows.q.shape
    S, kept, directions = nodes - 1, windows.memory.shape[1], possible.size1_in(0)
    # Unknowns of a step: state and memory at its start, accelerations at its stages.
    w = casadi.MX.sym("w", 2 * n + kept + 2 * n, K * S)
    z = casadi.MX.sym("z", directions)
    start, a = w[: 2 * n + kept, :], w[2 * n + kept :, :]
    applied = casadi.DM(windows.tau.reshape(K * S, 2 * n).T)
    q, dq, memory, missing = step.map(K * S)(
        start[:n, :], start[n : 2 * n, :], a, start[2 * n :, :], z, applied
    )
    end = casadi.vertcat(q, dq, memory)
    later = [k for k in range(K * S) if k % S]
    meets = end[:, [k - 1 for k in later]] - start[:, later]
    size = np.sqrt(np.mean(windows.tau**2, axis=(0, 1, 2))).clip(min=np.finfo(float).tiny)
    balance = missing / casadi.DM(np.tile(size, 2))
    measured = casadi.DM(windows.q[:, 1:].reshape(K * S, n).T)
    error = (q - measured) / casadi.DM(windows.deviation)
    unknowns = casadi.vertcat(casadi.vec(w), z)
    residual = casadi.vertcat(casadi.vec(error) / np.sqrt(S), z)
    guess, lower, upper = _bounds(windows, directions)
    motion = casadi.vertcat(casadi.vec(meets), casadi.vec(balance))
    solver = _solver(unknowns, residual, casadi.vertcat(motion, possible(z)))
    most = np.concatenate([np.zeros(motion.shape[0]), np.full(possible.size1_out(0), np.inf)])
    found = solver(x0=guess, lbx=lower, ubx=upper, lbg=0.0, ubg=most)
    status = str(solver.stats()["return_status"]).replace("_", " ").lower()
    return np.array(found["x"]).ravel()[-directions:], status


def _solver(unknowns: casadi.MX, residual: casadi.MX, constraints: casadi.MX) -> casadi.Function:
    """IPOPT with Gauss and Newton's Hessian: the residual's own, which leaves the constraints' out."""
    slope = casadi.jacobian(residual, unknowns)
    p, weight, multipliers = (
        casadi.MX.sym("p", 0),
        casadi.MX.sym("lam_f"),
        casadi.MX.sym("lam_g", constraints.shape[0]),
    )
    hessian = casadi.Function(
        "hessian",
        [unknowns, p, weight, multipliers],
        [casadi.triu(2 * weight * casadi.mtimes(slope.T, slope))],
        ["x", "p", "lam_f", "lam_g"],
        ["triu_hess_gamma_x_x"],
    )
    options = {
        "hess_lag": hessian,
        "print_time": False,
        "ipopt": {
            "print_level": 0,
            "sb": "yes",
            "max_iter": ITERATIONS,
            "tol": TOLERANCE,
            "max_cpu_time": SECONDS,
        },
    }
    problem = {"x": unknowns, "f": casadi.sumsqr(residual), "g": constraints}
    return casadi.nlpsol("refinement", "ipopt", problem, options)


def _bounds(
    windows: Windows, directions: int
) -> tuple[Float[ndarray, " u"], Float[ndarray, " u"], Float[ndarray, " u"]]:
    """Where the search begins, and bounds: windows start in the measured state."""
    K, nodes, n = windows.q.shape
    S = nodes - 1
    memory = np.repeat(windows.memory[:, None], S, axis=1)
    states = np.concatenate([windows.q[:, :-1], windows.dq[:, :-1], memory], axis=2)
    whole = np.concatenate([states, windows.ddq.reshape(K, S, 2 * n)], axis=2)
    free = np.full(whole.shape, np.inf)
    free[:, 0, : states.shape[2]] = 0.0
    guess = np.concatenate([whole.ravel(), np.zeros(directions)])
    reach = np.concatenate([free.ravel(), np.full(directions, np.inf)])
    return guess, guess - reach, guess + reach
