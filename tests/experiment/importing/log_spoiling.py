"""Ways to spoil a log, each drawn at random: its bytes, its text, or what was measured."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from tests.experiment.importing.laboratory_logs import Truth

CELLS = (
    "", " ", "nan", "inf", "-1e999", "1e308", "1e-320", "0x1p3", "1_0", "--1", "1.2.3", '"1"', '"',
    "'", "1;2", "é", "\u2212" + "1", "57.3", "1e9", "9" * 400, "#", "None", "12:61:00", "2026-13-01",
    "TRUE", "=A1", "q_1", "\0", "٣",
)  # fmt: skip


def spoiled_bytes(content: bytes, rng: np.random.Generator) -> bytes:
    """Cut off, altered, doubled or emptied somewhere."""
    at = int(rng.integers(0, len(content)))
    kind = rng.choice(
        ["cut", "bytes", "zeros", "double", "drop", "empty"], p=[0.3, 0.25, 0.1, 0.1, 0.2, 0.05]
    )
    if kind == "cut":
        return content[:at]
    if kind == "empty":
        return b""
    span = int(rng.integers(1, 400))
    new = {"bytes": rng.bytes(span), "zeros": bytes(span), "double": content[at : at + span] * 2}
    return content[:at] + new.get(str(kind), b"") + content[at + span :]


def spoiled_text(content: bytes, rng: np.random.Generator) -> bytes:
    """A cell, a row, a column or the encoding of a table is another."""
    coding = "utf-16" if content.startswith(b"\xff\xfe") else "utf-8"
    lines = content.decode(coding).splitlines()
    mark = max(";\t, ", key=lines[-1].count)
    rows = [line.split(mark) for line in lines]
    row = int(rng.integers(0, rng.choice([3, len(rows)])))
    column = int(rng.integers(0, len(rows[row])))
    kind = rng.choice(["cell", "column", "row", "order", "coding", "mark"], p=[0.4, *[0.12] * 5])
    if kind == "cell":
        rows[row][column] = str(rng.choice(CELLS))
    elif kind == "column":
        cell = str(rng.choice(CELLS))
        other = int(rng.integers(0, len(rows[row])))
        what = rng.integers(0, 3)
        for cells in rows[int(rng.integers(0, 2)) :]:
            if column < len(cells) and other < len(cells):
                cells[column : column + 1] = ([], [cell], [cells[other]] * 2)[what]
    elif kind == "row":
        rows[row : row + 1] = ([], rows[row : row + 1] * 40, [[]], [rows[0]])[rng.integers(0, 4)]
    elif kind == "order":
        first = int(rng.integers(0, 2))
        rows[first:] = [rows[first + int(i)] for i in rng.permutation(len(rows) - first)]
    elif kind == "mark":
        mark = str(rng.choice([":", "|", "  ", ",", ";", "\t", "\n"]))
    else:
        coding = str(rng.choice(["utf-16", "utf-32", "latin-1", "cp037"]))
    return "\r\n".join(mark.join(cells) for cells in rows).encode(coding, errors="replace")


def _value(truth: Truth, rng: np.random.Generator) -> Truth:
    """One measured value, a row, a column or all of them are no measurement."""
    name = str(rng.choice(["q", "dq", "tau"]))
    values = getattr(truth, name).copy()
    k, j = int(rng.integers(0, len(values))), int(rng.integers(0, values.shape[1]))
    where = ((k, j), (k,), (slice(None), j), (slice(k, None),), (slice(None),))[rng.integers(0, 5)]
    values[where] = rng.choice([np.nan, np.inf, 1e300, -1e300, 0.0, 1e-310, 1e12, 7.0])
    return dataclasses.replace(truth, **{name: values})


def _scale(truth: Truth, rng: np.random.Generator) -> Truth:
    name = str(rng.choice(["q", "dq", "tau"]))
    factor = rng.choice([57.3, 1e3, 1e-3, -1.0, 1e6, 1e-9, 0.0])
    return dataclasses.replace(truth, **{name: getattr(truth, name) * factor})


def _time(truth: Truth, rng: np.random.Generator) -> Truth:
    """Time stands, runs backwards, jumps, repeats itself or is mixed up."""
    steps, k = truth.stamp - truth.stamp[0], int(rng.integers(0, len(truth.stamp)))
    jump = np.where(np.arange(len(steps)) >= k, rng.choice([10**9, 10**17, -(10**9)]), 0)
    shuffled = rng.permutation(steps)
    new = (steps * 0, steps[::-1], steps + jump, steps // 10**8 * 10**8, shuffled, steps // 1000)
    stamp = truth.stamp[0] + new[rng.integers(0, 6)]
    return dataclasses.replace(truth, stamp=stamp, t=(stamp - truth.stamp[0]) / 1e9)


def _rows(truth: Truth, rng: np.random.Generator) -> Truth:
    """Few rows, the same row many times, or rows in any order."""
    count = len(truth.t)
    few = np.arange(min(count, rng.choice([1, 2, 3, 5, 20])))
    kept = (few, np.zeros(count, int), rng.permutation(count), rng.integers(0, count, count))
    chosen = kept[rng.integers(0, 4)]
    return Truth(*(getattr(truth, field.name)[chosen] for field in dataclasses.fields(truth)))


SPOILERS: tuple[Callable[[Truth, np.random.Generator], Truth], ...] = (_value, _scale, _time, _rows)


def spoiled_truth(truth: Truth, rng: np.random.Generator) -> Truth:
    """What an arm cannot have done, to be logged by the real libraries."""
    for _ in range(int(rng.integers(1, 3))):
        truth = SPOILERS[rng.integers(0, len(SPOILERS))](truth, rng)
    return truth
