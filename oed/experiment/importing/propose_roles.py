"""Which parts of the logs are for estimation, which for validation, which for the test."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.counted import counted
from oed.experiment.importing.repetition import find_period
from oed.experiment.recording import ROLES, Role
from oed.experiment.recording_checks import PARAMETERS_PER_JOINT

SHARES = (0.6, 0.8)  # of the time, at which validation and test begin
PAUSE = 1.0  # [s] of standstill, or without a row, that parts one motion from the next
STANDSTILL = 0.01  # of a joint's usual speed
USUAL = 0.95  # of the rows are slower
LEAST_PARTS = 3
NAMED: dict[Role, tuple[str, ...]] = {
    "estimation": ("estimation", "train", "identification", "calibration"),
    "validation": ("validation", "valid", "val"),
    "test": ("test", "holdout"),
}


@dataclass(frozen=True)
class Timed:
    """A log as far as roles depend on it.

    Attributes:
        stem: The file's name without its suffix.
        t: (N,) [s].
        q: (N, n) [rad or m].
        episode: (N,) index of the episode of each row; None where the log has none.
    """

    stem: str
    t: Float[ndarray, " samples"]
    q: Float[ndarray, "samples joints"]
    episode: Int[ndarray, " samples"] | None = None


@dataclass(frozen=True)
class Part:
    """Rows of a log with a role.

    Attributes:
        log: Index of the log.
        role: What they are for.
        rows: First row and the row behind the last, from 0; None for all rows.
        repetitions: Whole periods that they hold.
        period: Of the motion [s].
    """

    log: int
    role: Role
    rows: tuple[int, int] | None = None
    repetitions: int | None = None
    period: float | None = None


def propose_roles(logs: Sequence[Timed]) -> tuple[tuple[Part, ...], str]:
    """Divide logs into recordings with roles.

    Args:
        logs: In the order in which they were recorded.

    Returns:
        The parts in the order of time, and why they are so, in one line.
    """
    if len(logs) > 1:
        return _by_files(logs)
    (log,) = logs
    for parts, what in ((_episodes(log), "episodes"), (_motions(log), "motions between pauses")):
        if len(parts) >= LEAST_PARTS:
            roles = _shared_out([log.t[end - 1] - log.t[start] for start, end in parts])
            found = _merged(parts, roles)
            if _are_long_enough(found, log):
                return found, f"roles: {len(parts)} {what}, {_counts(roles)}"
    period = find_period(log.t, log.q)
    if period is not None:
        return _by_periods(log, period)
    return _by_time(log)


def _by_files(logs: Sequence[Timed]) -> tuple[tuple[Part, ...], str]:
    named: list[Role | None] = [_named_role(log.stem) for log in logs]
    if all(named) and "estimation" in named:
        return (
            tuple(Part(i, role) for i, role in enumerate(named) if role is not None),
            "roles: by the names of the files",
        )
    roles = _shared_out([float(log.t[-1] - log.t[0]) for log in logs])
    parts = tuple(Part(i, role) for i, role in enumerate(roles))
    return parts, f"roles: {counted(len(logs), 'log')} in the order given, {_counts(roles)}"


def _named_role(stem: str) -> Role | None:
    words = stem.lower().replace("-", "_").split("_")
    return next((role for role, known in NAMED.items() if any(w in known for w in words)), None)


def _shared_out(durations: Sequence[float]) -> list[Role]:
    """Roles of parts in the order of time: 60, 20 and 20 % of it, each role at least one part."""
    count = len(durations)
    if count == 1:
        return ["estimation"]
    middle = (np.cumsum(durations) - np.asarray(durations) / 2) / np.sum(durations)
    first = int(np.clip(np.searchsorted(middle, SHARES[0]), 1, max(1, count - 2)))
    second = int(np.clip(np.searchsorted(middle, SHARES[1]), first + 1, max(first + 1, count - 1)))
    return [ROLES[int(i >= first) + int(i >= second)] for i in range(count)]


def _counts(roles: Sequence[Role]) -> str:
    return ", ".join(f"{roles.count(role)} for {role}" for role in ROLES if role in roles)


def _episodes(log: Timed) -> list[tuple[int, int]]:
    if log.episode is None:
        return []
    edges = np.flatnonzero(np.diff(log.episode)) + 1
    starts, ends = [0, *edges.tolist()], [*edges.tolist(), len(log.t)]
    return list(zip(starts, ends, strict=True))


def _motions(log: Timed) -> list[tuple[int, int]]:
    """Stretches of rows, parted in the middle of each pause."""
    steps = np.diff(log.t)
    speed = np.abs(np.diff(log.q, axis=0)) / np.where(steps > 0, steps, np.inf)[:, None]
    usual = np.quantile(speed, USUAL, axis=0)
    rests = (speed <= STANDSTILL * usual).all(axis=1) | (steps >= PAUSE)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], rests, [0]])))
    pauses = [
        (start, end)
        for start, end in zip(edges[::2], edges[1::2], strict=True)
        if log.t[end] - log.t[start] >= PAUSE and start > 0 and end < len(rests)
    ]
    cuts = [0, *(int((start + end) // 2) + 1 for start, end in pauses), len(log.t)]
    return [(a, b) for a, b in itertools.pairwise(cuts) if b > a]


def _merged(parts: Sequence[tuple[int, int]], roles: Sequence[Role]) -> tuple[Part, ...]:
    """One recording a role: parts of one role follow one another."""
    found = []
    for role in ROLES:
        own = [part for part, given in zip(parts, roles, strict=True) if given == role]
        if own:
            found.append(Part(0, role, (own[0][0], own[-1][1])))
    return tuple(found)


def _are_long_enough(parts: Sequence[Part], log: Timed) -> bool:
    least = PARAMETERS_PER_JOINT * log.q.shape[1]
    return all(part.rows is None or part.rows[1] - part.rows[0] >= least for part in parts)


def _by_periods(log: Timed, period: float) -> tuple[tuple[Part, ...], str]:
    """Whole periods to each role; what is left over at the end is left out."""
    step = float(np.median(np.diff(log.t)))
    count = int((log.t[-1] - log.t[0] + 1.5 * step) / period)
    roles = _shared_out([period] * count)
    parts = []
    for role in ROLES:
        own = [i for i, given in enumerate(roles) if given == role]
        if own:
            start, end = log.t[0] + period * own[0], log.t[0] + period * (own[-1] + 1)
            # A row that rounding puts just before a period's start belongs to it.
            first, last = np.searchsorted(log.t, [start - step / 1e3, end - step / 1e3])
            parts.append(Part(0, role, (int(first), int(last)), len(own), period))
    if not _are_long_enough(parts, log):
        return _by_time(log)
    why = (
        f"roles: the motion repeats every {period:.6g} s, {count} times; {_counts(roles)}. "
        "Validation and test thus visit nothing new: record another motion for them"
    )
    return tuple(parts), why


def _by_time(log: Timed) -> tuple[tuple[Part, ...], str]:
    least = PARAMETERS_PER_JOINT * log.q.shape[1]
    end = len(log.t)
    cuts = [
        0,
        *(int(np.searchsorted(log.t, log.t[0] + s * (log.t[-1] - log.t[0]))) for s in SHARES),
        end,
    ]
    parts = tuple(
        Part(0, role, (a, b)) for role, a, b in zip(ROLES, cuts[:-1], cuts[1:], strict=True)
    )
    if _are_long_enough(parts, log):
        return parts, "roles: one motion without pauses or repetitions: 60, 20 and 20 % of its time"
    if end >= 2 * least:
        cut = end - max(least, round((1 - SHARES[0]) * end))
        why = "roles: one short motion: the first part for estimation, the last for validation"
        return (Part(0, "estimation", (0, cut)), Part(0, "validation", (cut, end))), why
    return (Part(0, "estimation"),), "roles: too short to hold anything out: all is for estimation"
