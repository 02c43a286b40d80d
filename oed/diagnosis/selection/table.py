"""A score test of every candidate over a grid of its shapes, all at once.

Columns are laid out once, in single precision and on as many blocks of rows as a number of bytes
holds: this only tells which candidates are worth a closer look.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from jaxtyping import Int
from numpy import ndarray

from oed.diagnosis.candidates.candidate import Candidate, Values
from oed.diagnosis.evidence.columns import white_effect
from oed.diagnosis.evidence.criterion import Worth
from oed.diagnosis.evidence.fit import Beside, Span, project
from oed.diagnosis.evidence.model import Fitted
from oed.diagnosis.selection.screen import least_price, most_gained, promised
from oed.dynamics.effects.catalogue import Context
from oed.dynamics.effects.effect import Effect
from oed.parallel_map import parallel_map

COLUMN_BYTES = 200_000_000  # of all candidates' columns on the rows of one table; a search has two
SINGLE = float(np.finfo(np.float32).max)  # beyond, or not a number, nothing can be told
BLOCK = 50  # rows that are kept together where not all are


@dataclass(frozen=True, eq=False)
class Line:
    """A candidate at some shapes in the table.

    Attributes:
        candidate: What.
        values: Its shapes.
        places: joint -> its columns in that joint's matrix.
        squares: joint -> (k, k) X' X.
    """

    candidate: Candidate
    values: Values
    places: dict[int, slice]
    squares: dict[int, ndarray]


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of all candidates on some rows.

    Attributes:
        lines: What they are.
        rows: Which rows.
        columns: One (R', K) matrix a joint.
    """

    lines: tuple[Line, ...]
    rows: Int[ndarray, " rows"]
    columns: tuple[ndarray, ...]


def lay_out(fitted: Fitted, candidates: Sequence[Candidate]) -> Table:
    """Evaluate all candidates over their grids, for the torque as it is modelled by now."""
    problem, context = fitted.problem, fitted.context
    asked = []
    for candidate in candidates:
        for values in candidate.grid(context):
            try:
                asked.append((candidate, values, candidate.effect(context, values)))
            except ValueError:
                continue
    whole = sum(
        len(e.parameters) * (1 if c.joint is not None else problem.rows.joints) for c, _, e in asked
    )
    used = np.flatnonzero(fitted.projection.used)
    most = COLUMN_BYTES // (4 * max(whole, 1))
    every = max(1, -(-len(used) // max(most, 1)))
    rows = used[(np.arange(len(used)) // BLOCK) % every == 0]

    found = parallel_map(lambda line: _seen(line[2], fitted, rows), asked)
    lines: list[Line] = []
    parts: list[list[ndarray]] = [[] for _ in range(problem.rows.joints)]
    ends = [0] * problem.rows.joints
    for (candidate, values, _), columns in zip(asked, found, strict=True):
        places, squares = {}, {}
        for j, (kept, own) in columns.items():
            places[j] = slice(ends[j], ends[j] + kept.shape[1])
            squares[j] = own
            parts[j].append(kept)
            ends[j] += kept.shape[1]
        if columns:
            lines.append(Line(candidate, values, places, squares))
    matrices = []
    for own in parts:
        matrices.append(
            np.concatenate(own, axis=1) if own else np.zeros((len(rows), 0), np.float32)
        )
        own.clear()
    return Table(tuple(lines), rows, tuple(matrices))


def _seen(
    effect: Effect, fitted: Fitted, rows: Int[ndarray, " rows"]
) -> dict[int, tuple[ndarray, ndarray]]:
    """White columns of an effect on some rows, in single precision, and X' X: joint by joint."""
    columns = white_effect(effect, fitted.installed, fitted.problem.rows)
    if not all(np.abs(c).max(initial=0.0) < SINGLE for c in columns.values()):
        return {}
    kept = {j: own[rows] for j, own in columns.items()}
    return {j: (own.astype(np.float32), own.T @ own) for j, own in kept.items()}


def ranked(
    table: Table,
    fitted: Fitted,
    wanted: Callable[[Line], bool],
    per_place: int = 3,
) -> list[list[tuple[float, Line]]]:
    """Plausible lines of each candidate, best first, and the candidates by their best.

    Args:
        table: Of columns.
        fitted: Beside which they stand.
        wanted: Whether a line is asked for.
        per_place: Lines of each candidate.
    """
    projection, problem = fitted.projection, fitted.problem
    joints = problem.rows.joints
    rows, share = table.rows, len(table.rows) / max(int(projection.used.sum()), 1)
    whole, variance = np.ones(len(rows), dtype=bool), projection.weights**-2
    seen = project(projection.residual[:, rows], projection.columns[:, rows], whole, variance)
    basis, left = seen.basis, seen.span.left
    span = Span(basis, left / np.sqrt(share), projection.weights)
    inside, scores = [], []
    for j in range(joints):
        both = np.concatenate([basis[j], left[j][:, None]], axis=1) * projection.weights[j]
        product = (both.astype(np.float32).T @ table.columns[j]).astype(float)
        inside.append(product[:-1] / np.sqrt(share))
        scores.append(product[-1] / share)
    counted = fitted.rows(projection.used)

    def promise(line: Line) -> Worth | None:
        beside = Beside(
            span,
            {j: x * (projection.weights[j] ** 2 / share) for j, x in line.squares.items()},
            {j: scores[j][place] for j, place in line.places.items()},
            {j: inside[j][:, place] for j, place in line.places.items()},
        )
        if most_gained(beside, counted) <= least_price(line.candidate, problem):
            return None
        return promised(line.candidate, line.values, fitted, beside, counted)

    asked = [line for line in table.lines if wanted(line)]
    found: dict[str, list[tuple[Worth, Line]]] = {}
    for line, own in zip(asked, parallel_map(promise, asked), strict=True):
        if own is not None:
            found.setdefault(line.candidate.label, []).append((own, line))
    supported = (_supported(own, fitted.context, per_place) for own in found.values())
    return sorted((own for own in supported if own), key=lambda own: -own[0][0])


def _supported(
    lines: list[tuple[Worth, Line]], context: Context, most: int
) -> list[tuple[float, Line]]:
    """Of a candidate's lines the best within its prior's support."""
    lines.sort(key=lambda x: -x[0].nats)
    possible = (
        (own.nats, line)
        for own, line in lines
        if line.candidate.excluded(context, line.values, own.coefficients) is None
    )
    return list(islice(possible, most))
