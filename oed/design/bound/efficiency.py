"""How much of the information that any motion could give a design gives: D-efficiency."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from oed.design.bound.deadline import Deadline, OutOfTime
from oed.design.bound.estimated_bound import SearchSettings, estimated_bound
from oed.design.bound.information_bound import BoundSettings, InformationBound, information_bound
from oed.design.bound.weights import WeightsNotFound
from oed.design.design import Design
from oed.design.problem import DesignProblem
from oed.errors import OedError

CERTIFIED_JOINTS = 2  # branch and bound over the states of more joints takes hours
MOST_JOINTS = 10  # beyond, the accelerations have too many vertices to try


@dataclass(frozen=True)
class Effort:
    """How hard to bound.

    Attributes:
        proofs: Settings of the certified bound, one after the other; the lowest bound counts.
        search: Settings of the estimate.
        cpu_seconds: After which to do without; of wall time `PATIENCE` times as many.
    """

    proofs: tuple[BoundSettings, ...] = tuple(
        BoundSettings(degree=degree, tolerance=0.01, proof_tolerance=0.02, most_boxes=300_000)
        for degree in (2, 4)
    )
    search: SearchSettings = field(default_factory=SearchSettings)
    cpu_seconds: float = 30.0


QUICK = Effort(
    (BoundSettings(degree=0, first_atoms=800, states_per_round=4000, proof_tolerance=0.05),),
    SearchSettings(first_states=300, rounds=2, candidates=200, kept=50, sweeps=3, last_steps=20),
    cpu_seconds=5.0,
)
PATIENCE = 20.0  # wall seconds a CPU second, on a machine that does other work as well


class NoBound(OedError):
    """There is no bound to hold a design against; the message says why."""


@dataclass(frozen=True)
class DEfficiency:
    """(det Lambda / det of the bound)^(1/b) of a design, in continuous time.

    Attributes:
        value: From 0 to 1; the share of every parameter's information, in the geometric mean,
            that the best periodic motion of any parametrisation could give at most.
        kind: Whether the bound is proven or searched for.
        J_d_bound: log10 det of the bound, of as many instants as the design has.
        how: How the bound was found, in a sentence.
    """

    value: float
    kind: Literal["certified", "estimated"]
    J_d_bound: float
    how: str


def d_efficiency(
    design: Design, rng: np.random.Generator, effort: Effort | None = None
) -> DEfficiency:
    """Hold a design against a bound: proven up to two joints, estimated up to ten.

    Args:
        design: Any.
        rng: Of the states looked at; a proof does not depend on it.
        effort: How hard to work; the default if None.

    Raises:
        NoBound: If there are too many joints, or prior information, of which the bound knows
            nothing; if none is found, or not in time.
    """
    problem, effort = design.problem, effort or Effort()
    if problem.model.robot.n > MOST_JOINTS:
        raise NoBound(f"no bound is known for more than {MOST_JOINTS} joints")
    if problem.is_told_before:
        raise NoBound("the bound knows nothing of earlier experiments")
    deadline = Deadline.after(effort.cpu_seconds, PATIENCE * effort.cpu_seconds)
    try:
        bound, how = _bound(design, rng, effort, deadline)
    # Whatever goes wrong in a bound, it must not take the design down that it is to judge.
    except (OedError, ValueError, ArithmeticError) as error:
        raise NoBound(f"no bound was found: {error}") from error
    instants = len(problem.instants)
    horizon = None if problem.trajectory.is_periodic else design.horizon
    value = bound.efficiency(design.J_d_continuous, instants, horizon)
    if not np.isfinite(value):
        raise NoBound("no bound was found: the information is singular to rounding")
    return DEfficiency(value, bound.kind, bound.J_d(instants, horizon), how)


def _bound(
    design: Design, rng: np.random.Generator, effort: Effort, deadline: Deadline
) -> tuple[InformationBound, str]:
    """A bound, and how it was found."""
    problem = design.problem
    if problem.model.robot.n <= CERTIFIED_JOINTS:
        proven = _proven(problem, rng, effort, deadline)
        if proven is not None:
            return proven, _how_proven(proven)
    bound = estimated_bound(problem, design.z, rng, effort.search, deadline)
    how = _how_estimated(effort.search)
    return bound, f"{how}; the dual's maximum found is {bound.excess:.1%} above its least"


def _proven(
    problem: DesignProblem, rng: np.random.Generator, effort: Effort, deadline: Deadline
) -> InformationBound | None:
    """The lowest of the proven bounds; None where no proof could be made."""
    bounds = []
    for settings in effort.proofs:
        try:
            bound = information_bound(
                problem.model,
                problem.base,
                problem.limits,
                rng,
                covariance=problem.covariance,
                settings=settings,
                certify=True,
                deadline=deadline,
            )
        # A bound that fails leaves the others valid.
        except (WeightsNotFound, OutOfTime, ValueError):
            continue
        bounds.append(bound)
    return min(bounds, key=lambda bound: bound.log10_det, default=None)


def _how_proven(bound: InformationBound) -> str:
    return (
        f"convex relaxation over visited states with {bound.functions} test functions, its dual "
        f"checked over all admissible states by branch and bound ({bound.boxes} boxes)"
    )


def _how_estimated(search: SearchSettings) -> str:
    return (
        "convex relaxation over visited states with the test functions q_j dq_k, its dual "
        f"checked where a random local search looked ({search.first_states} random states, the "
        f"design's own, {search.rounds} rounds of column generation): not proven"
    )
