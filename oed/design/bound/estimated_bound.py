"""An estimate of the information bound for arms of more than two joints.

The relaxation is the one of `information_bound`, with the test functions q_j dq_k. Its best
measure is sought on a finite set of admissible states that grows where the dual is too large:
random states, those of a design, and what a local search finds from there. For any positive
M and any multipliers y, every measure obeys tr(M Lambda) <= h = max over all states of
tr(M A) - y . rate, hence log det Lambda <= b log(h / b) - log det M. Here that maximum is the
largest value that the search met, which nobody proves to be the largest there is: the bound is
estimated, not certified.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from jaxtyping import Float
from numpy import ndarray

from oed.design.bound.balance import Monomials
from oed.design.bound.balanced_ascent import AscentPoint, ascend, gradient
from oed.design.bound.deadline import NEVER, Deadline
from oed.design.bound.information_bound import InformationBound
from oed.design.bound.states import ViableStates
from oed.design.criteria import whitening
from oed.design.problem import DesignProblem
from oed.dynamics.compiled import CompiledRegressor
from oed.dynamics.motion import Motion


@dataclass(frozen=True)
class SearchSettings:
    """How hard to look; numbers, not seconds, so that the same seed gives the same estimate.

    Attributes:
        first_states: Random states to begin with.
        rounds: Of ascent and search.
        steps: Of the ascent in each.
        candidates: States from which each search starts, half of them random.
        kept: The best of them, which are improved and join the others.
        sweeps: Of improvement by random moves.
        reach: Least and largest move, relative to a coordinate's range.
        forgotten: Weight below which a state may be dropped.
        last_steps: Of the ascent after the last search.
    """

    first_states: int = 1500
    rounds: int = 12
    steps: int = 25
    candidates: int = 1200
    kept: int = 250
    sweeps: int = 12
    reach: tuple[float, float] = (0.003, 0.3)
    forgotten: float = 1e-7
    last_steps: int = 60


@dataclass(frozen=True)
class _Atoms:
    """States with what they tell.

    Attributes:
        x: (states, 2 n) coordinates.
        rows: (states, n, b) whitened regressor rows.
        rates: (states, m) of the test functions.
    """

    x: Float[ndarray, "states coordinates"]
    rows: Float[ndarray, "states joints base"]
    rates: Float[ndarray, "states functions"]

    def __getitem__(self, which: ndarray) -> _Atoms:
        return _Atoms(self.x[which], self.rows[which], self.rates[which])

    def joined(self, other: _Atoms) -> _Atoms:
        pairs = zip(
            (self.x, self.rows, self.rates), (other.x, other.rows, other.rates), strict=True
        )
        return _Atoms(*(np.concatenate(pair) for pair in pairs))

    def dual(self, at: AscentPoint) -> Float[ndarray, " states"]:
        """tr(M A) - y . rate."""
        return gradient(self.rows, at.information) - self.rates @ at.multipliers


def estimated_bound(
    problem: DesignProblem,
    z: Float[ndarray, " size"],
    rng: np.random.Generator,
    settings: SearchSettings | None = None,
    deadline: Deadline = NEVER,
) -> InformationBound:
    """Estimate the largest log10 det of the mean information of a periodic motion.

    Args:
        problem: Model, base parameters, noise and limits; its prior and scaling are not used.
        z: A design. Its states are among those looked at, so that it cannot beat the estimate.
        rng: Of states and moves.
        settings: How hard to look.
        deadline: When to give up.

    Raises:
        OutOfTime: At the deadline.
    """
    settings = settings or SearchSettings()
    source = _Source.of(problem)
    own = source.of_motion(problem.trajectory.motion(z, problem.instants))
    atoms = own.joined(source.random(settings.first_states, rng))
    weights = np.full(len(atoms.x), 0.5 / (len(atoms.x) - len(own.x)))
    weights[: len(own.x)] = 0.5 / len(own.x)  # a design's own states balance
    point = ascend(atoms.rows, atoms.rates, weights, steps=settings.steps, deadline=deadline)
    for _ in range(settings.rounds):
        found = source.search(point, atoms, settings, rng, deadline)
        # The design's states stay, so that weights that balance always exist.
        is_kept = (point.weights > settings.forgotten) | (np.arange(len(atoms.x)) < len(own.x))
        atoms = atoms[is_kept].joined(found)
        weights = np.concatenate(
            [0.9 * point.weights[is_kept], np.full(len(found.x), 0.1 / len(found.x))]
        )
        point = ascend(atoms.rows, atoms.rates, weights, steps=settings.steps, deadline=deadline)
    point = ascend(
        atoms.rows, atoms.rates, point.weights, steps=settings.last_steps, deadline=deadline
    )
    highest = max(
        float(atoms.dual(point).max()),
        float(source.search(point, atoms, settings, rng, deadline).dual(point).max()),
    )
    return InformationBound.of_measure(
        point.information,
        highest,
        kind="estimated",
        functions=len(source.functions),
        boxes=0,
        longest_return=source.states.longest_return,
    )


@dataclass(frozen=True)
class _Source:
    """Admissible states of a problem and what they tell.

    Attributes:
        regressor: The compiled base regressor; affine in the acceleration.
        white: (n, n) factor that makes the noise of an instant white; None if it is.
        states: Admissible ones.
        functions: Test functions q_j dq_k.
    """

    regressor: CompiledRegressor
    white: Float[ndarray, "joints joints"] | None
    states: ViableStates
    functions: Monomials

    @classmethod
    def of(cls, problem: DesignProblem) -> _Source:
        n, covariance = problem.model.robot.n, problem.covariance
        fastest = np.abs(problem.limits.velocity).max(axis=1)
        # A bound for wider limits is a bound: the states want velocities symmetric about zero.
        states = ViableStates(problem.limits.with_(velocity=np.stack([-fastest, fastest], axis=1)))
        white = None
        if covariance is not None:
            white = whitening(np.diag(covariance) if covariance.ndim == 1 else covariance)
        position = problem.limits.position
        scale = np.concatenate([np.diff(position, axis=1)[:, 0] / 2, states.fastest])
        identity = np.eye(n, dtype=int)
        products = np.concatenate(
            [np.repeat(identity, n, axis=0), np.tile(identity, (n, 1))], axis=1
        )
        functions = Monomials(position.mean(axis=1), scale, products)
        return cls(problem.regressor, white, states, functions)

    def of_motion(self, motion: Motion) -> _Atoms:
        """The states of a motion; where it is beyond the box by rounding, next to it."""
        return _Atoms(self._coordinates(motion), self._rows(motion), self.functions.rates(motion))

    def random(self, count: int, rng: np.random.Generator) -> _Atoms:
        """Random states and vertices."""
        x, ddq = self.states.sample(count, rng)
        return self.of_states(x, ddq)

    def of_states(
        self, x: Float[ndarray, "states coordinates"], ddq: Float[ndarray, "states joints"]
    ) -> _Atoms:
        """Atoms of coordinates and accelerations."""
        motion = self.states.motion(x, ddq)
        return _Atoms(x, self._rows(motion), self.functions.rates(motion))

    def search(
        self,
        point: AscentPoint,
        atoms: _Atoms,
        settings: SearchSettings,
        rng: np.random.Generator,
        deadline: Deadline,
    ) -> _Atoms:
        """States where the dual is large: the best of many, moved at random while that helps."""
        lower, upper = self.states.box.T
        fresh, _ = self.states.sample(settings.candidates // 2, rng)
        count = settings.candidates - len(fresh)
        near = atoms.x[rng.choice(len(atoms.x), size=count, p=point.weights / point.weights.sum())]
        x = np.concatenate([fresh, near])
        ddq, value = self._best_vertex(x, point)
        best = np.argsort(-value)[: settings.kept]
        least, most = np.log(settings.reach)
        x, ddq, value = x[best], ddq[best], value[best]
        for _ in range(settings.sweeps):
            deadline.check()
            reach = np.exp(rng.uniform(least, most, (len(x), 1)))
            moves = rng.random(x.shape) < 2 / x.shape[1]
            step = reach * moves * (upper - lower) * rng.standard_normal(x.shape)
            tried = np.clip(x + step, lower, upper)
            vertex, reached = self._best_vertex(tried, point)
            is_better = reached > value
            x[is_better], ddq[is_better] = tried[is_better], vertex[is_better]
            value[is_better] = reached[is_better]
        return self.of_states(x, ddq)

    def _best_vertex(
        self, x: Float[ndarray, "states coordinates"], point: AscentPoint
    ) -> tuple[Float[ndarray, "states joints"], Float[ndarray, " states"]]:
        """The accelerations at which the dual is largest in every state, and its value.

        Rows and rates are affine in the acceleration, so the dual is a quadratic of it: given by
        its values with no and with one unit acceleration, and largest at a vertex.
        """
        n, count = self.regressor.joints, len(x)
        units = np.concatenate([np.zeros((1, n)), np.eye(n)])
        atoms = self.of_states(np.repeat(x, n + 1, axis=0), np.tile(units, (count, 1)))
        lower = np.linalg.cholesky(point.information)
        whitener = scipy.linalg.solve_triangular(lower, np.eye(len(lower)), lower=True)
        rows = (atoms.rows.reshape(-1, len(lower)) @ whitener.T).reshape(count, n + 1, -1)
        rates = (atoms.rates @ point.multipliers).reshape(count, n + 1)
        rows[:, 1:] -= rows[:, :1]
        rates[:, 1:] -= rates[:, :1]
        gram = rows @ rows.transpose(0, 2, 1)
        vertices = self.states.vertices
        vertices = np.concatenate([np.ones((len(vertices), 1)), vertices], axis=1)
        squares = (vertices[:, :, None] * vertices[:, None, :]).reshape(len(vertices), -1)
        values = gram.reshape(count, -1) @ squares.T - rates @ vertices.T
        best = values.argmax(axis=1)
        return self.states.vertices[best], values[np.arange(count), best]

    def _rows(self, motion: Motion) -> Float[ndarray, "states joints base"]:
        rows = self.regressor.dense(self.regressor.entries(motion))
        return rows if self.white is None else self.white @ rows

    def _coordinates(self, motion: Motion) -> Float[ndarray, "states coordinates"]:
        """(v, s) of each joint: s from 0 to 1 along the positions that v leaves."""
        down, up = np.abs(self.states.limits.acceleration).T
        low = self.states.limits.position[:, 0] + motion.dq**2 / (2 * up)
        high = self.states.limits.position[:, 1] - motion.dq**2 / (2 * down)
        share = (motion.q - low) / np.maximum(high - low, np.finfo(float).tiny)
        x = np.stack([motion.dq, np.clip(share, 0.0, 1.0)], axis=2)
        return x.reshape(len(motion), -1)
