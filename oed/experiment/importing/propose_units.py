"""In which units a log seems to be written, by the ranges of its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.experiment.importing.motions import find_runs
from oed.experiment.limit_checks import IMPOSSIBLE_RMS
from oed.experiment.recording_checks import LARGEST_STEP
from oed.experiment.units import DEGREE, TIMES, units_of
from oed.robot import Robot

# A joint may be beyond the limits of its robot's file by so much, which are often rounded or
# narrowed; in degrees it would be beyond by 57.
WITHIN = 1.5
FASTEST = 5e-5  # [s] between rows: no joint is logged at more than 20 kHz
SAME = 0.1  # relative distance at which the ratio of velocity and slope is taken for a known one
WINDOWS = 50  # over whose ends velocities are integrated
# LeRobot's Feetech and Dynamixel servos: encoders of 12 bits, at the middle in the zero pose.
TICKS_PER_TURN = 4096.0
MIDDLE = 2048.0
LEAST_TICKS = 100.0  # of travel: whole numbers that move less may be degrees


@dataclass(frozen=True)
class UnitProposal:
    """Units by quantity where they are not SI, with `ticks_per_turn` and `zero` if need be.

    Attributes:
        units: One a quantity, or one a joint.
        ticks_per_turn: Of encoders; None where none are in ticks.
        zero: (n,) what is logged at the robot's zero.
        notes: Why, a line each.
    """

    units: Mapping[str, tuple[str, ...]]
    ticks_per_turn: float | None = None
    zero: Float[ndarray, " joints"] | None = None
    notes: tuple[str, ...] = ()


def propose_units(
    values: Mapping[str, Float[ndarray, "samples columns"]],
    robot: Robot,
    stated: Mapping[str, tuple[str, ...]],
) -> UnitProposal:
    """Find the units of a log.

    Args:
        values: Columns (N, n) of "q" and "tau", (N, 1) of "t", and maybe of "dq".
        robot: With limits.
        stated: Units that are known, by quantity; `ticks_per_turn` is not among them.
    """
    units, notes = dict(stated), []
    zero, ticks = None, None
    if "t" in values and "t" not in stated:
        unit, step = _time_unit(values["t"][:, 0])
        if unit != "s":
            units["t"] = (unit,)
            notes.append(f"t: steps of {step:.4g} can only be {unit}")
    if "q" not in stated:
        unit, note = _position_units(values["q"], robot)
        if unit:
            units["q"] = unit
            notes.append(note)
        if "ticks" in unit:
            zero, ticks = np.full(robot.n, MIDDLE), TICKS_PER_TURN
    if "dq" in values and "dq" not in stated and "t" in values:
        unit, note = _velocity_unit(values, units, robot, ticks)
        if unit:
            units["dq"] = unit
            notes.append(note)
    if "tau" not in stated:
        unit, note = _torque_unit(values["tau"], robot)
        if unit:
            units["tau"] = unit
            notes.append(note)
    return UnitProposal(units, ticks, zero, tuple(notes))


def _time_unit(t: Float[ndarray, " samples"]) -> tuple[str, float]:
    """The largest unit in which rows follow one another as fast as an arm needs."""
    steps = np.diff(t)
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    for unit in ("s", "ms", "us", "ns"):
        if FASTEST <= step * TIMES[unit] < LARGEST_STEP * (1 - 1e-6):
            return unit, step
    return "s", step


def _position_units(
    q: Float[ndarray, "samples joints"], robot: Robot
) -> tuple[tuple[str, ...], str]:
    """Units of positions; nothing where they are SI, or can be nothing that is known."""
    largest = np.abs(q).max(axis=0)
    bound = np.abs(robot.limits.position).max(axis=1)
    bound = np.where(np.isfinite(bound), bound, 2 * np.pi)
    turns = np.array([joint.kind == "revolute" for joint in robot.joints])
    beyond = largest > WITHIN * bound
    if not beyond.any():
        return (), ""
    j = int(np.argmax(largest / bound))
    is_whole = bool((q == np.round(q)).all()) and float(np.ptp(q, axis=0).max()) > LEAST_TICKS
    if is_whole and turns.all():
        why = (
            f"q: whole numbers up to {largest[j]:g}: taken for ticks of an encoder of "
            f"{TICKS_PER_TURN:g} a turn that stands at {MIDDLE:g} where the joint is at zero; "
            "correct ticks_per_turn, zero and sign if yours is another"
        )
        return ("ticks",), why
    scaled = largest * np.where(turns, DEGREE, 1e-3)
    # A joint that a wrong unit would put within its limits tells nothing against it.
    if (scaled <= WITHIN * bound).all() and (beyond | (largest == 0))[turns].any():
        units = tuple("deg" if is_turning else "mm" for is_turning in turns)
        if not beyond[~turns].any():
            units = tuple("deg" if is_turning else "m" for is_turning in turns)
        why = (
            f"q: up to {largest[j]:.4g} at joint {robot.joints[j].name!r}, whose limit is "
            f"{bound[j]:.4g} {robot.joints[j].unit('rad')}: {' and '.join(dict.fromkeys(units))}"
        )
        return units[:1] if len(set(units)) == 1 else units, why
    return (), ""


def _velocity_unit(
    values: Mapping[str, Float[ndarray, "samples columns"]],
    units: Mapping[str, tuple[str, ...]],
    robot: Robot,
    ticks: float | None,
) -> tuple[tuple[str, ...], str]:
    """The unit in which velocity is the slope of position over time, in the longest run."""
    t = values["t"][:, 0] * TIMES.get(units.get("t", ("s",))[0], 1.0)
    start, end = max(find_runs(t), key=lambda rows: rows[1] - rows[0])
    values = {key: column[start:end] for key, column in values.items()}
    t = t[start:end]
    edges = np.unique(np.linspace(0, len(t) - 1, WINDOWS + 1).astype(int))
    dq = values["dq"]
    travelled = np.concatenate(
        [np.zeros((1, robot.n)), np.cumsum((dq[1:] + dq[:-1]) / 2 * np.diff(t)[:, None], axis=0)]
    )
    moved = np.diff(values["q"][edges], axis=0)
    integral = np.diff(travelled[edges], axis=0)
    squares = np.sum(moved**2, axis=0)
    moves = squares > 0
    products = np.sum(moved * integral, axis=0)
    ratio = float(np.median(products[moves] / squares[moves])) if moves.any() else 1.0
    logged = units.get("q", ("rad",))[0]
    if robot.joints[0].kind != "revolute" or len(set(units.get("q", ("rad",)))) > 1:
        return (), ""
    per_unit = units_of("q").get(logged, 1.0) / (ticks or 1.0)
    for unit, factor in units_of("dq").items():
        scale = factor / (ticks or TICKS_PER_TURN) if unit.startswith("ticks") else factor
        if abs(ratio * scale / per_unit - 1) < SAME:
            if unit == "rad/s":
                return (), ""
            return (unit,), f"dq: {ratio:.4g} times the slope of q over t as logged: {unit}"
    return (), ""


def _torque_unit(
    tau: Float[ndarray, "samples joints"], robot: Robot
) -> tuple[tuple[str, ...], str]:
    """Thousandths where the rms is beyond what a drive can give, and a thousandth is not."""
    limit = np.abs(robot.limits.torque).max(axis=1)
    share = np.sqrt(np.mean(tau**2, axis=0)) / limit
    j = int(np.argmax(share))
    is_turning = all(joint.kind == "revolute" for joint in robot.joints)
    if is_turning and share[j] >= IMPOSSIBLE_RMS and share[j] < 1e3:
        why = (
            f"tau: rms {share[j]:.3g} times the limit of joint {robot.joints[j].name!r} can only "
            "be mN m"
        )
        return ("mN m",), why
    return (), ""
