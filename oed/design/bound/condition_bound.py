"""A proven lower bound on J_k: no motion within the limits has a smaller condition number.

For A, B >= 0 the largest eigenvalue of Lambda is at least tr(B Lambda) / tr B, the least one at most
tr(A Lambda) / tr A. Where every state's rows D have tr((B - A) D' D) >= 0, so has their sum, and

    cond Lambda >= tr A / tr B.

The best A and B for sampled states are the dual of the least condition number of any mixture of states
(a semidefinite program: Boyd and Vandenberghe 2004, Convex Optimization, section 7.5); states at which
they fail are added, and branch and bound proves the rest. That states lie on one trajectory is ignored:
the bound holds for every motion, periodic or not, and may be far from any. It is one of continuous
time: instants at which a joint turns, and friction has no sign, have no part of that.
"""

from __future__ import annotations

import itertools
import warnings
from dataclasses import dataclass

import casadi
import cvxpy as cp
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.bound.branch_and_bound import Boxes, SmoothFunction, prove_maximum
from oed.design.bound.states import ViableStates
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.torque_model import TorqueModel
from oed.errors import OedError
from oed.robot import JointLimits

FIRST_CELLS = 4  # that branch and bound starts from, along each coordinate; even, to cut at zero
KEPT, HALF = 100, 0.5  # one of so many states is moved; by about so many of its coordinates
STEPS = np.geomspace(0.1, 1e-3, 60)  # of a coordinate's range
AT_EDGE = 0.3  # of the coordinates of a sampled state: the form is least at the ends of ranges


class ConditionNotBounded(OedError):
    """No bound could be proven with the work that was allowed."""


@dataclass(frozen=True)
class ConditionSettings:
    """How hard to work.

    Attributes:
        first_states: Random states to begin with.
        searched: Random states looked at in each round.
        rounds: Of adding states at which the certificate fails.
        margin: Share of the sampled optimum that is given up, so that the rest can be proven.
        most_boxes: Of branch and bound, in each round.
    """

    first_states: int = 3000
    searched: int = 60_000
    rounds: int = 40
    margin: float = 0.02
    most_boxes: int = 5_000_000


@dataclass(frozen=True)
class ConditionBound:
    """A lower bound on the condition number of every motion's information.

    Attributes:
        J_k: The bound, proven over all states.
        sampled: What the relaxation allows on the states that were looked at; the largest bound
            of this kind is between both.
        A: (b, b) of the certificate, positive semidefinite.
        B: (b, b) likewise.
        boxes: Of the proof.
    """

    J_k: float
    sampled: float
    A: Float[ndarray, "base base"]
    B: Float[ndarray, "base base"]
    boxes: int


def condition_bound(
    model: TorqueModel,
    base: BaseParameters,
    limits: JointLimits,
    rng: np.random.Generator,
    settings: ConditionSettings | None = None,
) -> ConditionBound:
    """Bound cond Lambda of every motion within the limits, under R_v = I, columns as they are.

    Args:
        model: Its columns may jump where a joint's velocity changes sign, and are smooth elsewhere.
        base: Which columns.
        limits: Finite in position and acceleration.
        rng: Of the first states; the proof does not depend on it.
        settings: How hard to work.

    Raises:
        ConditionNotBounded: If no certificate held.
    """
    settings, space = settings or ConditionSettings(), _Space(model, base, ViableStates(limits))
    states = space.sample(settings.first_states, rng)
    for _ in range(settings.rounds):
        A, B = _relaxed(space.atoms(states))
        kept = (1 - settings.margin) * A
        failing = space.search(B - kept, settings.searched, rng)
        if len(failing):
            states = np.concatenate([states, failing, space.search(B - A, settings.searched, rng)])
            continue
        proof = prove_maximum(
            space.shortfall(B - kept),
            space.boxes(),
            tolerance=0.0,
            at_least=0.0,
            most_boxes=settings.most_boxes,
        )
        if proof.upper <= 0.0:
            bound, sampled = (float(np.trace(own) / np.trace(B)) for own in (kept, A))
            return ConditionBound(bound, sampled, kept, B, proof.boxes)
        states = np.concatenate([states, space.failing(proof.points, B - kept)])
    raise ConditionNotBounded(
        f"no certificate held after {settings.rounds} rounds: allow more, or a wider margin"
    )


def _relaxed(
    atoms: Float[ndarray, "states base base"],
) -> tuple[Float[ndarray, "base base"], Float[ndarray, "base base"]]:
    """A and B of the largest tr A / tr B whose form is not negative on some states."""
    size = atoms.shape[1]
    A, B = cp.Variable((size, size), PSD=True), cp.Variable((size, size), PSD=True)
    flat = atoms.reshape(len(atoms), -1)
    flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    kept: list[cp.Constraint] = [
        cp.trace(B) == 1.0,  # pyright: ignore[reportAssignmentType]  # cvxpy's == is no bool
        flat @ cp.vec(B - A, order="C") >= 0.0,
    ]
    problem = cp.Problem(cp.Maximize(cp.trace(A)), kept)
    with warnings.catch_warnings():  # what is not accurate is proven afterwards, or not
        warnings.filterwarnings("ignore", "Solution may be inaccurate")
        problem.solve(solver=cp.CLARABEL)
    if A.value is None or B.value is None:
        raise ConditionNotBounded(f"the relaxation has no solution: {problem.status}")
    return _semidefinite(A.value), _semidefinite(B.value)


def _semidefinite(matrix: Float[ndarray, "base base"]) -> Float[ndarray, "base base"]:
    """A matrix without what a solver leaves below zero: the certificate asks for exactly that."""
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
    return (vectors * np.maximum(values, 0.0)) @ vectors.T


@dataclass(frozen=True)
class _Space:
    """All states of a model: velocities, shares of the position's range, accelerations."""

    model: TorqueModel
    base: BaseParameters
    states: ViableStates

    @property
    def box(self) -> Float[ndarray, "coordinates 2"]:
        return np.concatenate([self.states.box, self.states.limits.acceleration])

    def atoms(self, x: Float[ndarray, "states coordinates"]) -> Float[ndarray, "states base base"]:
        """D' D of each state."""
        twice = 2 * self.states.joints
        motion = self.states.motion(x[:, :twice], x[:, twice:])
        D = self.base.reduce(self.model.columns(motion))
        return np.einsum("nji,njk->nik", D, D)

    def sample(self, count: int, rng: np.random.Generator) -> Float[ndarray, "states coordinates"]:
        """Random states, many of their coordinates at an end of its range."""
        lower, upper = self.box.T
        shape = (count, len(lower))
        inside = rng.uniform(lower, upper, shape)
        ends = np.where(rng.random(shape) < 0.5, lower, upper)
        return np.where(rng.random(shape) < AT_EDGE, ends, inside)

    def failing(
        self, x: Float[ndarray, "states coordinates"], form: Float[ndarray, "base base"]
    ) -> Float[ndarray, "failing coordinates"]:
        """Those of some states where a form is negative."""
        return x[self._form(x, form) < 0.0]

    def search(
        self, form: Float[ndarray, "base base"], count: int, rng: np.random.Generator
    ) -> Float[ndarray, "failing coordinates"]:
        """States where a form is negative: the least of many, moved at random while that helps."""
        x = self.sample(count, rng)
        best = np.argsort(self._form(x, form))[: count // KEPT]
        x, (lower, upper) = x[best], self.box.T
        value = self._form(x, form)
        for step in STEPS:
            move = step * (upper - lower) * rng.standard_normal(x.shape)
            trial = np.clip(x + move * (rng.random(x.shape) < HALF), lower, upper)
            found = self._form(trial, form)
            x = np.where((found < value)[:, None], trial, x)
            value = np.minimum(found, value)
        return x[value < 0.0]

    def _form(
        self, x: Float[ndarray, "states coordinates"], form: Float[ndarray, "base base"]
    ) -> Float[ndarray, " states"]:
        """tr(form D' D), over tr(D' D) so that states compare."""
        atoms = self.atoms(x)
        return np.einsum("nij,ij->n", atoms, form) / np.einsum("nii->n", atoms)

    def shortfall(self, form: Float[ndarray, "base base"]) -> SmoothFunction:
        """-tr(form D' D) as a function of the state."""
        n = self.states.joints
        x, q, v = casadi.SX.sym("x", 3 * n), casadi.SX.sym("q", n), casadi.SX.sym("v", n)
        columns = self.model.symbolic_columns(q, v, x[2 * n :], 0.0)
        D = columns[:, self.base.columns.tolist()]
        value = -casadi.sum1(casadi.sum2(casadi.mtimes(D, casadi.DM(form)) * D))
        at_q, at_v = self.states.symbolic(x[: 2 * n])
        value = casadi.substitute(value, casadi.vertcat(q, v), casadi.vertcat(at_q, at_v))
        return SmoothFunction.of(value, x, casadi.SX.sym("none", 0))

    def boxes(self) -> Boxes:
        """The whole set, cut at zero velocity; and joints that stand still, whose sign is zero."""
        n = self.states.joints
        parts = [self._boxes(rest) for rest in itertools.product((False, True), repeat=n)]
        middle, half = (np.concatenate(part) for part in zip(*parts, strict=True))
        return Boxes(middle, half, np.zeros((len(middle), 0)))

    def _boxes(self, rest: tuple[bool, ...]) -> tuple[ndarray, ndarray]:
        """Of the joints that move; the others have neither velocity nor acceleration."""
        n, edges = self.states.joints, []
        for k, (lower, upper) in enumerate(self.box):
            is_speed = k >= 2 * n or k % 2 == 0
            joint = k - 2 * n if k >= 2 * n else k // 2
            is_still = is_speed and rest[joint]
            cells = np.zeros(2) if is_still else np.linspace(lower, upper, FIRST_CELLS + 1)
            edges.append(np.stack([cells[:-1], cells[1:]], axis=1))
        grid = np.meshgrid(*[np.arange(len(e)) for e in edges], indexing="ij")
        cells = np.stack([e[g.ravel()] for e, g in zip(edges, grid, strict=True)], axis=1)
        return cells.mean(axis=2), np.diff(cells, axis=2)[:, :, 0] / 2
