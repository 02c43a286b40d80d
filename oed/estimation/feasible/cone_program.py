"""A linear or quadratic objective over a product of cones: the form that conic solvers share.

The form of a feasible estimate is known, and only its numbers change from solve to solve. A
modelling language that finds the form anew takes six times as long as the solver itself for two
joints; its parameters, which spare that, take a minute to compile for thirty.

Coordinates of a symmetric matrix are by the orthonormal basis of its upper triangle, row by row,
in which a semidefinite cone's multiplier is a matrix in the same coordinates (O'Donoghue, Chu,
Parikh and Boyd 2016, "Conic optimization via operator splitting and homogeneous self-dual
embedding"; Goulart and Chen 2024, "Clarabel: an interior-point solver for conic programs with
quadratic objectives").
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import clarabel
import numpy as np
import scs
from jaxtyping import Float, Int
from numpy import ndarray
from scipy.sparse import csc_array

from oed.errors import OedError

ConicSolver = Literal["clarabel", "scs"]
# What a solver says of a point that is worth looking at: solved, to its tolerance or to a looser
# one, or stopped by its limit of steps. All else is a proof that there is none, or a failure.
SOLVED = ("Solved", "AlmostSolved", "solved", "solved (inaccurate - reached max_iters)")
STOPPED = ("MaxIterations",)


class SolverFailed(OedError):
    """No solver came to a solution that passes its own check.

    Attributes:
        attempts: Solver and outcome, one line each.
    """

    def __init__(self, message: str, attempts: tuple[str, ...]) -> None:
        super().__init__(f"{message}: {'; '.join(attempts)}")
        self.attempts = attempts


@dataclass(frozen=True)
class ConeRows:
    """s = offset - matrix x, in one kind of cone.

    Attributes:
        matrix: (r, v), with its zeros: an arm's is small, and solvers get what is not zero.
        offset: (r,).
    """

    matrix: Float[ndarray, "r v"]
    offset: Float[ndarray, " r"]

    @classmethod
    def none(cls, variables: int) -> ConeRows:
        """No rows."""
        return cls(np.zeros((0, variables)), np.zeros(0))

    def __len__(self) -> int:
        return len(self.offset)


@dataclass(frozen=True)
class ConeProgram:
    """min x^T diag(quadratic) x / 2 + linear^T x over x with every s in its cone.

    Attributes:
        quadratic: (v,) not negative.
        linear: (v,).
        zero: s = 0.
        nonnegative: s >= 0.
        semidefinite: s are the coordinates of positive semidefinite matrices.
        orders: Of these matrices, one after another.
        exponential: s are triples (a, b, c) with b exp(a / b) <= c and b > 0.
    """

    quadratic: Float[ndarray, " v"]
    linear: Float[ndarray, " v"]
    zero: ConeRows
    nonnegative: ConeRows
    semidefinite: ConeRows
    orders: Sequence[int]
    exponential: ConeRows

    @property
    def parts(self) -> tuple[ConeRows, ...]:
        """All rows, in the order of their cones."""
        return self.zero, self.nonnegative, self.semidefinite, self.exponential


@dataclass(frozen=True)
class ConeSolution:
    """A point, and the prices of the cones there.

    Attributes:
        x: (v,).
        nonnegative: (k,) multipliers, not negative but for rounding.
        semidefinite: (w,) coordinates of multipliers, likewise.
        status: In the solver's words.
        iterations: It took.
    """

    x: Float[ndarray, " v"]
    nonnegative: Float[ndarray, " k"]
    semidefinite: Float[ndarray, " w"]
    status: str
    iterations: int

    @property
    def is_solved(self) -> bool:
        """Whether the solver takes it for a solution, to its tolerance or a looser one."""
        return self.status in SOLVED


def solve_cones(
    program: ConeProgram, solver: ConicSolver, settings: Mapping[str, float | int]
) -> ConeSolution:
    """Solve by Clarabel (interior point) or SCS (first order), from nothing.

    Args:
        program: To solve.
        solver: By which.
        settings: Of its own, by its names.

    Raises:
        SolverFailed: If there is no solution to look at.
    """
    matrix = np.vstack([part.matrix for part in program.parts])
    offset = np.concatenate([part.offset for part in program.parts])
    solve = _by_clarabel if solver == "clarabel" else _by_scs
    x, prices, status, iterations = solve(program, matrix, offset, settings)
    if status not in SOLVED + STOPPED or not (np.isfinite(x).all() and np.isfinite(prices).all()):
        raise SolverFailed("no solution", (f"{solver}: {status}",))
    ends = np.cumsum([len(part) for part in program.parts])
    return ConeSolution(x, prices[ends[0] : ends[1]], prices[ends[1] : ends[2]], status, iterations)


Found = tuple[Float[ndarray, " v"], Float[ndarray, " rows"], str, int]


def _by_clarabel(
    program: ConeProgram,
    matrix: Float[ndarray, "rows v"],
    offset: Float[ndarray, " rows"],
    settings: Mapping[str, float | int],
) -> Found:
    order = _column_by_column(program)
    options = clarabel.DefaultSettings()
    options.verbose = False
    for name, value in settings.items():
        setattr(options, name, value)
    cones = [
        clarabel.ZeroConeT(len(program.zero)),
        clarabel.NonnegativeConeT(len(program.nonnegative)),
        *(clarabel.PSDTriangleConeT(size) for size in program.orders),
        *(clarabel.ExponentialConeT() for _ in range(len(program.exponential) // 3)),
    ]
    found = clarabel.DefaultSolver(
        _diagonal(program.quadratic),
        program.linear,
        csc_array(matrix[order]),
        offset[order],
        cones,
        options,
    ).solve()
    prices = np.empty(len(order))
    prices[order] = found.z
    return np.array(found.x), prices, str(found.status), int(found.iterations)


def _by_scs(
    program: ConeProgram,
    matrix: Float[ndarray, "rows v"],
    offset: Float[ndarray, " rows"],
    settings: Mapping[str, float | int],
) -> Found:
    data = {
        "P": _diagonal(program.quadratic),
        "A": csc_array(matrix),
        "b": offset,
        "c": program.linear,
    }
    cone = {
        "z": len(program.zero),
        "l": len(program.nonnegative),
        "s": list(program.orders),
        "ep": len(program.exponential) // 3,
    }
    found = scs.SCS(data, cone, verbose=False, **settings).solve()
    told = found["info"]
    return found["x"], found["y"], str(told["status"]), int(told["iter"])


def _diagonal(entries: Float[ndarray, " v"]) -> csc_array:
    places = np.flatnonzero(entries)
    return csc_array((entries[places], (places, places)), shape=(len(entries), len(entries)))


def _column_by_column(program: ConeProgram) -> Int[ndarray, " rows"]:
    """The rows with every upper triangle column by column, as Clarabel has it."""
    order = np.arange(sum(len(part) for part in program.parts))
    start = len(program.zero) + len(program.nonnegative)
    for size in program.orders:
        row, column = np.triu_indices(size)
        order[start : start + len(row)] = start + np.lexsort((row, column))
        start += len(row)
    return order
