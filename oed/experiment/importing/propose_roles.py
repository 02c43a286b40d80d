"""Which parts of the logs are for estimation, which for validation, which for the test."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.counted import counted
from oed.experiment.importing.motions import Rows, find_motions, find_runs, is_moving, with_rest
from oed.experiment.importing.repetition import find_period
from oed.experiment.recording import ROLES, Role
from oed.experiment.recording_checks import PARAMETERS_PER_JOINT

SHARES = (0.6, 0.8)  # of the time, at which validation and test begin
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
    runs, left_out = long_runs(log)
    if len(runs) == 1:
        start, end = runs[0]
        parts, why = _of_one_run(_cut(log, runs[0]))
        if (start, end) == (0, len(log.t)):
            return parts, why
        return tuple(moved(part, start, end) for part in parts), f"{why}{left_out}"
    roles = _shared_out([float(log.t[end - 1] - log.t[start]) for start, end in runs])
    parts = tuple(Part(0, role, rows) for rows, role in zip(runs, roles, strict=True))
    why = f"roles: {len(runs)} runs, for each of which the clock was set back; {_counts(roles)}"
    return parts, f"{why}{left_out}"


def long_runs(log: Timed) -> tuple[list[Rows], str]:
    """The runs of a log that are long enough to be a recording, and a word on the others.

    A log without one is returned whole, for whoever reads it to say what it lacks.
    """
    runs = find_runs(log.t)
    kept = [(a, b) for a, b in runs if b - a >= _least_rows(log)] or [(0, len(log.t))]
    short = len(runs) - len(kept)
    some = f"; {counted(short, 'run')} of too few rows left out"
    return kept, some if short and kept != [(0, len(log.t))] else ""


def _of_one_run(log: Timed) -> tuple[tuple[Part, ...], str]:
    moving = is_moving(log.t, log.q)
    motions = with_rest(log.t, find_motions(log.t, moving))
    for parts, what in ((_episodes(log), "episodes"), (motions, "motions between pauses")):
        if len(parts) >= LEAST_PARTS:
            roles = _shared_out([log.t[end - 1] - log.t[start] for start, end in parts])
            found = _merged(parts, roles)
            if _are_long_enough(found, log):
                return found, f"roles: {len(parts)} {what}, {_counts(roles)}"
    first, last = int(moving.argmax()), len(moving) - int(moving[::-1].argmax())
    motion = _cut(log, (first, last))
    period = find_period(motion.t, motion.q)
    if period is not None and (found := _by_periods(motion, period)) is not None:
        return tuple(moved(part, first, last) for part in found[0]), found[1]
    return _by_time(log, moving)


def _cut(log: Timed, rows: Rows) -> Timed:
    start, end = rows
    episode = None if log.episode is None else log.episode[start:end]
    return Timed(log.stem, log.t[start:end], log.q[start:end], episode)


def moved(part: Part, start: int, end: int) -> Part:
    """A part of the rows from `start` to `end` of a log as one of the whole log."""
    first, last = part.rows or (0, end - start)
    return dataclasses.replace(part, rows=(first + start, last + start))


def _by_files(logs: Sequence[Timed]) -> tuple[tuple[Part, ...], str]:
    named: list[Role | None] = [_named_role(log.stem) for log in logs]
    if all(named) and "estimation" in named:
        known: list[Role] = [role for role in named if role is not None]
        return parts_of(logs, known), "roles: by the names of the files"
    roles = _shared_out([float(log.t[-1] - log.t[0]) for log in logs])
    why = f"roles: {counted(len(logs), 'log')} in the order given, {_counts(roles)}"
    return parts_of(logs, roles), why


def parts_of(logs: Sequence[Timed], roles: Sequence[Role]) -> tuple[Part, ...]:
    """Whole logs, each with its role; one part a run where a log's clock is set back."""
    found = []
    for i, (log, role) in enumerate(zip(logs, roles, strict=True)):
        runs, _ = long_runs(log)
        found += [Part(i, role, None if rows == (0, len(log.t)) else rows) for rows in runs]
    return tuple(found)


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


def _merged(parts: Sequence[tuple[int, int]], roles: Sequence[Role]) -> tuple[Part, ...]:
    """One recording a role: parts of one role follow one another."""
    found = []
    for role in ROLES:
        own = [part for part, given in zip(parts, roles, strict=True) if given == role]
        if own:
            found.append(Part(0, role, (own[0][0], own[-1][1])))
    return tuple(found)


def _are_long_enough(parts: Sequence[Part], log: Timed) -> bool:
    least = _least_rows(log)
    return all(part.rows is None or part.rows[1] - part.rows[0] >= least for part in parts)


def _least_rows(log: Timed) -> int:
    return PARAMETERS_PER_JOINT * log.q.shape[1]


def _by_periods(log: Timed, period: float) -> tuple[tuple[Part, ...], str] | None:
    """Whole periods to each role; what is left over at the end is left out; None if too short."""
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
        return None
    why = (
        f"roles: the motion repeats every {period:.6g} s, {count} times; {_counts(roles)}. "
        "Validation and test thus visit nothing new: record another motion for them"
    )
    return tuple(parts), why


def _by_time(log: Timed, moving: Bool[ndarray, " samples"]) -> tuple[tuple[Part, ...], str]:
    """Shares of the time in motion; where the arm stands before and after it is left out."""
    rows = np.flatnonzero(moving)
    ((start, end),) = with_rest(log.t, [(int(rows[0]), int(rows[-1]) + 1)])
    steps = np.diff(log.t, prepend=log.t[0])
    steps[0] = 0.0
    passed = np.cumsum(np.where(moving, steps, 0.0))
    cuts = [start, *(int(np.searchsorted(passed, share * passed[-1])) for share in SHARES), end]
    parts = tuple(
        Part(0, role, cut) for role, cut in zip(ROLES, itertools.pairwise(cuts), strict=True)
    )
    idle = log.t[start] - log.t[0] + log.t[-1] - log.t[end - 1]
    left = f"; {idle:.3g} s at the ends, where the arm stands, left out" if idle > 0 else ""
    if _are_long_enough(parts, log):
        why = "roles: one motion without pauses or repetitions: 60, 20 and 20 % of its time"
        return parts, f"{why}{left}"
    least, count = _least_rows(log), end - start
    if count >= 2 * least:
        cut = end - max(least, round((1 - SHARES[0]) * count))
        why = "roles: one short motion: the first part for estimation, the last for validation"
        return (Part(0, "estimation", (start, cut)), Part(0, "validation", (cut, end))), why
    return (Part(0, "estimation"),), "roles: too short to hold anything out: all is for estimation"
