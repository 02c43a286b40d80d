"""Validation by rollout: does an arm that is simulated with a model move as the arm did?

From a measured state, under the measured torque, the model's equation of motion is integrated and
compared with the measured position after some horizons. An error of torque that is small at every
instant may add up to a large one of position, and a model that leaves out a spring or a loss drifts.

The velocity after a step is where the step's torque is evaluated (implicit Euler), so that a joint
that sticks stays: its friction, a steep function of the velocity, is solved and not followed. The
error of a step is then of first order: it is held to the step's half in the tests, and to Drake.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi
import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.array_function import array_function
from oed.dynamics.effects import State
from oed.dynamics.forward import EXACT, MOST_STEPS, NoAcceleration
from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import joint_pose
from oed.dynamics.online import of_the_arm, without_offline
from oed.dynamics.scalars import apply, plus
from oed.dynamics.torque_model import TorqueModel
from oed.errors import OedError
from oed.robot import Robot

HORIZONS = (0.1, 0.5, 1.0, 2.0)  # [s]
STEP = 1e-3  # [s] of the integration
WINDOWS = 4  # of a recording at most, spread over its length
LOOKED_AT = 50  # samples of a recording at which the mass matrix is looked at
SINGULAR = 1e-9  # of its largest eigenvalue: a smaller one is rounding
# Signs turn over this velocity at least: a joint that sticks creeps by no more, and a step's
# equation has a slope there. Encoders do not tell it from rest.
SIGN_WIDTH = 1e-3  # [rad/s or m/s]
ENOUGH = 1e6 * EXACT  # of the torque: far below the error of a step
LOST = 10.0  # [rad or m] off: beyond that a simulation has left the arm
FARTHEST = 1e3  # [rad or m] from zero: beyond that nothing is simulated any more
# [s] between the starts of windows at least: shorter horizons then share little.
SPACING = 0.25


@dataclass(frozen=True)
class Rollout:
    """How far a simulated arm is from the measured one, after each horizon.

    Attributes:
        horizons: (h,) [s].
        joint: (h, n) median over the windows [rad or m]: where one in a few leaves the arm, a mean
            would tell how far it flew.
        flange: (h,) the same of the last link's origin [m].
        windows: How many were simulated.
        lost: How many were farther off than `LOST`; where one found no acceleration any more, its error
            counts as that.
    """

    horizons: tuple[float, ...]
    joint: Float[ndarray, "horizons joints"]
    flange: Float[ndarray, " horizons"]
    windows: int
    lost: int


@dataclass(frozen=True)
class Track:
    """A recording to be followed.

    Attributes:
        motion: As it was measured, smoothed, without the ends where filters have not settled.
        t: (N,) time of the torque [s].
        tau: (N, n) torque as it was measured [N m or N].
    """

    motion: Motion
    t: Float[ndarray, " samples"]
    tau: Float[ndarray, "samples joints"]

    def starts(self, longest: float, most: int) -> Int[ndarray, " windows"]:
        """Samples of the motion from which a window of that length [s] can be simulated."""
        t = self.motion.t
        can = np.flatnonzero(t <= t[-1] - longest)
        if len(can) == 0:
            return can
        count = min(most, 1 + int((t[can[-1]] - t[can[0]]) / SPACING))
        return can[np.linspace(0, len(can) - 1, count).astype(int)]

    def at_the_arm(self, model: TorqueModel) -> Track:
        """The track with the torque that acted, as a model's measurement has it."""
        tau = self.tau
        for effect in reversed(model.measurement):
            tau = effect.undone(self.t, tau)
        return dataclasses.replace(self, tau=tau)


class NotSimulated(OedError):
    """A model's mass matrix is not positive definite: a torque would move the arm against itself."""


def roll_out(
    model: TorqueModel,
    parameters: Float[ndarray, " p"],
    tracks: Sequence[Track],
    *,
    horizons: Sequence[float] = HORIZONS,
    step: float = STEP,
    windows: int = WINDOWS,
    sign_width: float = SIGN_WIDTH,
) -> Rollout:
    """Simulate windows of recordings and compare.

    The torque that acts is the recorded one with what measurement did to it undone, as far as it
    can be; what of the model needs a whole recording is left out.

    Args:
        model: The torque model.
        parameters: Of all its columns.
        tracks: Held-out recordings.
        horizons: After which the error is taken [s], rising.
        step: Of the integration [s].
        windows: Most of them a recording.
        sign_width: Velocity over which every sign turns at least [rad/s].

    Raises:
        ValueError: If no recording is long enough.
        NotSimulated: If the mass matrix is not positive definite where the arm was.
    """
    arm = ImplicitArm.of(model, parameters, step, sign_width)
    errors, flanges, lost = [], [], 0
    for recorded in tracks:
        arm.require_inertia(recorded.motion)
        track = recorded.at_the_arm(model)
        for start in track.starts(horizons[-1], windows):
            found = arm.follow(track, int(start), horizons)
            when = track.motion.t[start] + np.array(horizons)
            measured = np.stack(
                [np.interp(when, track.motion.t, q) for q in track.motion.q.T], axis=1
            )
            off = np.abs(found - measured)
            lost += not off.max() < LOST
            gone = np.asarray(~np.isfinite(off).all(axis=1))
            ends = (last_origin(model.robot, q) for q in (np.nan_to_num(found), measured))
            away = np.linalg.norm(np.subtract(*ends), axis=1)
            errors.append(np.where(gone[:, None], LOST, off))
            flanges.append(np.where(gone, LOST, away))
    if not errors:
        raise ValueError(f"no recording is as long as {horizons[-1]:g} s and its filters' ends")
    return Rollout(
        tuple(horizons),
        np.median(errors, axis=0),
        np.median(flanges, axis=0),
        len(errors),
        lost,
    )


@dataclass(frozen=True)
class ImplicitArm:
    """An arm that is simulated with implicit Euler steps.

    Attributes:
        equation: (q, dq, ddq, memory) -> torque at the end of a step that accelerates by ddq, memory
            after it, derivative of the torque by ddq.
        begin: (q, dq, ddq) -> memory at the first instant.
        inertia: (q, dq, ddq) -> derivative of the torque at that instant by ddq: the mass matrix, and
            friction under the load that it makes.
        step: [s].
    """

    equation: casadi.Function
    begin: casadi.Function
    inertia: casadi.Function
    step: float

    @classmethod
    def of(
        cls,
        model: TorqueModel,
        parameters: Float[ndarray, " p"],
        step: float,
        sign_width: float = SIGN_WIDTH,
    ) -> ImplicitArm:
        """The arm of a model, without its measurement."""
        kept, own = without_offline(dataclasses.replace(model, measurement=()), parameters)
        n = kept.robot.n
        instants = of_the_arm(kept.effects, own, n, step)
        q, dq, ddq = (casadi.SX.sym(name, n) for name in ("q", "dq", "ddq"))
        memory = casadi.SX.sym("memory", len(instants.keeps))
        after = dq + step * ddq
        there, moving, rates = map(casadi.vertsplit, (q + step * after, after, ddq))
        state = State(0.0, there, moving, rates, sign_width)
        remembered = casadi.vertsplit(memory) if instants.keeps else []
        torque, following = (
            casadi.vertcat(casadi.SX(0, 1), *x) for x in instants.recall(state, remembered)
        )
        first = State(0.0, *(casadi.vertsplit(x) for x in (q, dq, ddq)))  # pyright: ignore[reportArgumentType]
        begun = instants.begin(first)
        now = casadi.vertcat(*instants.recall(first, begun)[0])
        outputs = [torque, following, casadi.jacobian(torque, ddq)]
        return cls(
            casadi.Function("step", [q, dq, ddq, memory], outputs, {"cse": True}),
            casadi.Function("begin", [q, dq, ddq], [casadi.vertcat(casadi.SX(0, 1), *begun)]),
            casadi.Function("inertia", [q, dq, ddq], [casadi.jacobian(now, ddq)], {"cse": True}),
            step,
        )

    def require_inertia(self, motion: Motion) -> None:
        """Make sure that torques accelerate the arm the way they act, along a motion.

        Raises:
            NotSimulated: If they do not, with the worst instant.
        """
        some = np.unique(np.linspace(0, len(motion) - 1, LOOKED_AT).astype(int))
        values = [
            np.linalg.eigvals(np.array(self.inertia(motion.q[k], motion.dq[k], motion.ddq[k]))).real
            for k in some
        ]
        least = [own.min() / max(np.abs(own).max(), np.finfo(float).tiny) for own in values]
        worst = int(np.argmin(least))
        if least[worst] <= SINGULAR:
            raise NotSimulated(
                f"the mass matrix has the eigenvalue {values[worst].min():.2g} beside "
                f"{values[worst].max():.2g} kg m^2 at t = {motion.t[some[worst]]:.3g} s: no bodies that "
                "exist have one such"
            )

    def follow(
        self, track: Track, start: int, horizons: Sequence[float]
    ) -> Float[ndarray, "horizons joints"]:
        """Position after each horizon; NaN from where no acceleration was found, or beyond `FARTHEST`."""
        motion = track.motion
        q, dq, ddq = motion.q[start], motion.dq[start], motion.ddq[start]
        memory = np.array(self.begin(q, dq, ddq)).ravel()
        counts = [round(h / self.step) for h in horizons]
        times = motion.t[start] + self.step * np.arange(1, counts[-1] + 1)
        applied = np.stack([np.interp(times, track.t, own) for own in track.tau.T], axis=1)
        found = np.full((len(horizons), len(q)), np.nan)
        equation = array_function(self.equation)
        for k in range(counts[-1]):
            try:
                ddq, memory = _accelerated(equation, (q, dq, ddq, memory), applied[k])
            except NoAcceleration:
                break
            dq = dq + self.step * ddq
            q = q + self.step * dq
            if not np.abs(q).max() < FARTHEST:
                break
            found[[c == k + 1 for c in counts]] = q
        return found


def _accelerated(
    equation: Callable[..., list[ndarray]],
    before: tuple[ndarray, ndarray, ndarray, ndarray],
    applied: Float[ndarray, " joints"],
) -> tuple[Float[ndarray, " joints"], Float[ndarray, " memory"]]:
    """Acceleration in a step under a torque, from (q, dq, ddq, memory), and the memory after it."""
    q, dq, ddq, memory = before
    following = memory
    enough = ENOUGH * max(np.abs(applied).max(), 1.0)
    for _ in range(MOST_STEPS):
        torque, following, slope = equation(q, dq, ddq, memory)
        missing = applied - torque[:, 0]
        if np.abs(missing).max() <= enough:
            break
        try:
            ddq = ddq + np.linalg.solve(slope, missing)
        except np.linalg.LinAlgError as error:
            raise NoAcceleration(f"the mass matrix is singular at q = {q}") from error
    return ddq, following.ravel()


def last_origin(robot: Robot, q: Float[ndarray, "samples joints"]) -> Float[ndarray, "samples 3"]:
    """Where the last link's frame is in the base frame [m]."""
    joint, place = robot.outward[-1], (0.0, 0.0, 0.0)
    while joint != -1:
        R, p = joint_pose(robot.joints[joint], q[:, joint])
        place = plus(p, apply(R, place))
        joint = robot.joints[joint].parent
    return np.stack([x + np.zeros(len(q)) for x in place], axis=1)
