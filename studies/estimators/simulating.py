"""Estimators that simulate the controlled arm: instruments, DIDIM, output and input error.

All know the controller and the reference, and start from what is believed beforehand.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from studies.estimators.arms import arm_of
from studies.estimators.conditions import Logs
from studies.estimators.loop import PERIOD, Disturbances, Runs, simulate
from studies.estimators.recipe import Equations, Found, Recipe

ROUNDS = 3  # DIDIM and instruments settle in two or three (Janot and others 2014)
STEPS = 3  # of Gauss and Newton's method
DIFFERENCE = 1e-3  # of each parameter's torque over the whole, for its derivative
SHARES = (1.0, 0.5, 0.25, 0.1, 0.0)  # of a step that are tried; none, where all are worse
FASTEST = 1e5  # [rad/s^2 or m/s^2] beyond which a simulation has left the arm
TRIMMED = 0.5  # [s] at each end


def simulated(key: str, logs: Logs, parameters: Float[ndarray, "sets base"]) -> Runs:
    """What an undisturbed arm would have done; not finite where it runs away."""
    nothing = Disturbances.none(len(logs.reference), arm_of(key).robot.n)
    with np.errstate(all="ignore"):
        return simulate(key, parameters, logs.reference, nothing)


def instruments(key: str, logs: Logs) -> list[Found | None]:
    """IDIM-IV: least squares with the simulated regressor as instruments (Janot and others 2014)."""

    def solve(e: Equations, Z: Float[ndarray, "rows base"]) -> Parameters:
        mixed = Z.T @ e.W
        parameters = np.linalg.solve(mixed, Z.T @ e.y)
        rest = e.y - e.W @ parameters
        half = np.linalg.solve(mixed, Z.T)
        return parameters, np.sqrt(np.var(rest) * np.sum(half**2, axis=1))

    return _settled(key, logs, solve)


def direct(key: str, logs: Logs) -> list[Found | None]:
    """DIDIM: measured torque on the simulated regressor (Gautier, Janot and Vandanjon 2013)."""

    def solve(e: Equations, Z: Float[ndarray, "rows base"]) -> Parameters:
        inverse = np.linalg.pinv(Z)
        parameters = inverse @ e.y
        rest = e.y - Z @ parameters
        return parameters, np.sqrt(np.var(rest) * np.sum(inverse**2, axis=1))

    return _settled(key, logs, solve)


Parameters = tuple[Float[ndarray, " base"], Float[ndarray, " base"]]


def _settled(
    key: str,
    logs: Logs,
    solve: Callable[[Equations, Float[ndarray, "rows base"]], Parameters],
) -> list[Found | None]:
    """Rounds of simulating all logs' arms and solving; None where an arm runs away."""
    arm, recipe = arm_of(key), Recipe(1 / (logs.every * PERIOD))
    given = [
        recipe.equations(arm, q, tau).with_weights()
        for q, tau in zip(logs.q, logs.tau, strict=True)
    ]
    found: list[Found | None] = [Found.bare(arm.believed) for _ in given]
    for _ in range(ROUNDS):
        alive = [k for k, each in enumerate(found) if each is not None]
        if not alive:
            break
        runs = simulated(key, logs, np.array([found[k].parameters for k in alive]))  # type: ignore[union-attr]
        for run, k in enumerate(alive):
            motion, (e, weights) = runs.motion(run, logs.every), given[k]
            if not np.abs(motion.ddq).max() < FASTEST:
                found[k] = None
                continue
            Z = recipe.regressor(arm, motion) * weights[:, None]
            scale = np.linalg.norm(Z, axis=0)
            parameters, std = solve(Equations(e.W / scale, e.y, e.joints), Z / scale)
            found[k] = Found.of_std(parameters / scale, std / scale)
    return found


def output_error(key: str, logs: Logs) -> list[Found | None]:
    """Closed-loop output error: parameters whose simulated arm moves as the logged one did."""
    return _closed_loop(key, logs, "q", logs.q)


def input_error(key: str, logs: Logs) -> list[Found | None]:
    """Closed-loop input error: parameters whose simulated controller asks for the logged torque."""
    return _closed_loop(key, logs, "torque", logs.tau)


def _closed_loop(
    key: str,
    logs: Logs,
    of: Literal["q", "torque"],
    measured: Float[ndarray, "runs rows joints"],
) -> list[Found | None]:
    """Gauss and Newton's method for each log, all trials of all logs simulated at once."""
    arm = arm_of(key)
    steps = _steps(key, logs)
    b, count = len(arm.base), len(measured)
    cut = round(TRIMMED / (logs.every * PERIOD))

    def errors(trials: Float[ndarray, "runs sets base"]) -> Float[ndarray, "rows joints runs sets"]:
        signal = getattr(simulated(key, logs, trials.reshape(-1, b)), of)[:: logs.every]
        signal = signal.reshape(*signal.shape[:2], count, -1)
        return (np.moveaxis(measured, 0, 2)[..., None] - signal)[cut:-cut]

    found = np.tile(arm.believed, (count, 1))
    spread = np.full((count, b), np.nan)
    for _ in range(STEPS):
        differences = np.concatenate([np.zeros((1, b)), np.diag(steps)])
        left = errors(found[:, None] + differences)
        deviation = np.sqrt(np.mean(left[..., 0] ** 2, axis=0))
        tried = np.repeat(found[:, None], len(SHARES), axis=1)
        for k in np.flatnonzero(np.isfinite(left).all(axis=(0, 1, 3))):
            slopes = (left[:, :, k, :1] - left[:, :, k, 1:]) / steps
            J = (slopes / deviation[:, k, None]).reshape(-1, b)
            scale = np.linalg.norm(J, axis=0)
            inverse = np.linalg.pinv(J / scale)
            step = inverse @ (left[:, :, k, 0] / deviation[:, k]).reshape(-1) / scale
            tried[k] += np.array(SHARES)[:, None] * step
            spread[k] = np.sqrt(np.sum(inverse**2, axis=1)) / scale
        costs = np.sum((errors(tried) / deviation[:, :, None]) ** 2, axis=(0, 1))
        best = np.argmin(np.nan_to_num(costs, nan=np.inf), axis=1)
        found = tried[np.arange(count), best]
    told = np.flatnonzero(np.all(np.isfinite(spread), axis=1))
    return [Found.of_std(found[k], spread[k]) if k in told else None for k in range(count)]


def _steps(key: str, logs: Logs) -> Float[ndarray, " base"]:
    """Of the differences: as much torque by each parameter, of the whole's `DIFFERENCE`."""
    arm = arm_of(key)
    columns = arm.model.columns(logs.reference[::20])[:, :, arm.base.columns]
    whole = np.linalg.norm(columns @ arm.believed)
    return DIFFERENCE * whole / np.linalg.norm(columns, axis=(0, 1))
