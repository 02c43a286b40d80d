"""The fit of a torque model to a log as it would be if something about the log were otherwise.

All recordings are fitted, with a rotor's inertia and a constant torque of each joint, as drives and sensors
have them whether or not they are declared. So every change of the log has as many parameters to fit it
with, what two of them leave can be compared as it is, and what is no fault of the log is not put down to one.
Friction may have any law, but takes power from every joint: so a sign tells where a joint hardly couples to others.

Each joint's rows and the torques of all joints are kept as one triangular factor (Golub and Van Loan,
Matrix Computations, section 5.3), and from it as normal equations in a basis that makes them well
conditioned, so that a fit with other torques takes a millisecond, however long the recordings.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.linalg import null_space, solve_triangular
from scipy.optimize import nnls

from oed.checkup.change import Change
from oed.dynamics.effects import RotorInertia
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.triangular import factor_of
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.signals.correlation_length import correlation_length
from oed.progress import told

RANK = 1e-8  # of the largest singular value, columns of one norm: beyond it a direction is rounding
STEPS = 50  # of the weights, which settle in a few
SETTLED = 1e-3  # relative change of the joints' mean squares
LEAST_RESIDUAL = 1e-4  # of the torque: a joint fitted to rounding must not outweigh all others


@dataclass(frozen=True)
class Outcome:
    """What a fit leaves.

    Attributes:
        change: Of the log that was fitted.
        relative: (n,) rms residual of each joint over the rms of its torque.
        residual: (n,) rms residual of each torque as logged [N m or N].
        parameters: (p + n,) of the model's columns, and each joint's constant.
    """

    change: Change
    relative: Float[ndarray, " joints"]
    residual: Float[ndarray, " joints"]
    parameters: Float[ndarray, " width"]

    def deviance(self, counts: Float[ndarray, " joints"]) -> float:
        """Minus twice the log likelihood, but for a constant that all fits to the same log share.

        Args:
            counts: (n,) independent samples of each torque as logged.
        """
        return 2 * float(counts @ np.log(self.residual))


@dataclass(frozen=True)
class NormalEquations:
    """Of each joint's rows, for all torques that may be its own.

    Attributes:
        basis: (p + n, r) of the parameters: combinations that differ on the recordings, first those that
            leave the power of friction as it is.
        power: (c, n) how much of the last c combinations makes each joint's friction take a unit of power.
        information: (n, r, r) products of the columns, mean over samples; likewise the others.
        products: (n, r, n) of the columns and each torque.
        squares: (n,) of each torque.
    """

    basis: Float[ndarray, "width rank"]
    power: Float[ndarray, "last joints"]
    information: Float[ndarray, "joints rank rank"]
    products: Float[ndarray, "joints rank joints"]
    squares: Float[ndarray, " joints"]

    @classmethod
    def of(
        cls,
        factors: Sequence[Float[ndarray, "_ columns"]],
        friction: Bool[ndarray, " parameters"],
        *,
        constants: bool,
    ) -> NormalEquations:
        """From the factors of rows [columns | 1 | velocity | torques].

        Args:
            factors: Of each joint's rows, of their mean over samples.
            friction: (p,) whether a parameter is one of friction.
            constants: Whether each joint has a constant torque.
        """
        n = len(factors)
        torques = [factor[:, -n:] for factor in factors]
        squares = np.array([np.sum(torques[j][:, j] ** 2) for j in range(n)])
        unit = np.sqrt(np.where(squares > 0, squares, 1.0))
        columns = [
            np.column_stack(
                [f[:, : -2 - n], np.outer(f[:, -2 - n], constants * (np.arange(n) == j))]
            )
            for j, f in enumerate(factors)
        ]
        whole = factor_of(c / s for c, s in zip(columns, unit, strict=True))
        norms = np.linalg.norm(whole, axis=0)
        used = norms > RANK * norms.max()
        _, sizes, right = np.linalg.svd(whole[:, used] / norms[used], full_matrices=False)
        kept = sizes > RANK * sizes[0]
        basis = np.zeros((len(norms), int(kept.sum())))
        basis[used] = right[kept].T / sizes[kept] / norms[used][:, None]
        taken = np.zeros((n, len(norms)))
        taken[:, : len(friction)] = [f[:, : -2 - n].T @ f[:, -1 - n] * friction for f in factors]
        holding = sizes[kept][:, None] * right[kept]
        turned, power = _power_apart(holding, taken[:, used] / norms[used])
        basis = basis @ turned
        own = [c @ basis for c in columns]
        return cls(
            basis,
            power,
            np.stack([c.T @ c for c in own]),
            np.stack([c.T @ t for c, t in zip(own, torques, strict=True)]),
            squares,
        )

    def fit(self, change: Change, counts: Float[ndarray, " joints"] | None = None) -> Outcome:
        """Maximum likelihood of the torques that a change means, every joint with its own variance.

        Args:
            change: With these columns.
            counts: Independent samples of each torque as logged; alike if None.
        """
        source, gain = list(change.source), np.array(change.gain)
        square = self.squares[source] * gain**2
        product = self.products[np.arange(len(source)), :, source] * gain[:, None]
        least = LEAST_RESIDUAL**2 * np.where(square > 0, square, 1.0)
        left, solved = np.maximum(square, least), np.zeros(self.basis.shape[1])
        for _ in range(STEPS):
            weights = (1.0 if counts is None else counts[source]) / left
            information = np.tensordot(weights, self.information, 1)
            solved = self._solve(information, weights @ product)
            before = left
            left = square - 2 * product @ solved + self.information @ solved @ solved
            left = np.maximum(left, least)
            if np.all(np.abs(left - before) < SETTLED * before):
                break
        relative = np.sqrt(np.where(square > 0, left / np.where(square > 0, square, 1.0), 0.0))
        residual = change.by_column(np.sqrt(left) / np.abs(gain))
        return Outcome(change, relative, residual, self.basis @ solved)

    def _solve(
        self, information: Float[ndarray, "rank rank"], product: Float[ndarray, " rank"]
    ) -> Float[ndarray, " rank"]:
        """Combinations of least squares with which friction drives no joint.

        What leaves its power as it is explains what it can; the powers are found beside it (Lawson
        and Hanson 1974, Solving Least Squares Problems, chapter 23).
        """
        # Weights of joints far apart may leave a combination to rounding.
        ridge = np.finfo(float).eps * np.trace(information)
        lower = np.linalg.cholesky(information + ridge * np.eye(len(product)))
        target = solve_triangular(lower, product, lower=True)
        last = slice(len(target) - len(self.power), None)
        beside = lower[last, last].T @ self.power
        target[last] = beside @ nnls(beside, target[last])[0]
        return solve_triangular(lower.T, target)


def _power_apart(
    holding: Float[ndarray, "rank parameters"], taken: Float[ndarray, "joints parameters"]
) -> tuple[Float[ndarray, "rank rank"], Float[ndarray, "last joints"]]:
    """A turn of combinations after which only the last ones change the power of friction.

    Args:
        holding: How much of each combination a unit of each parameter is.
        taken: Mean power that it takes from each joint.

    Returns:
        The turn; and how much of each of the last combinations a unit of each joint's power is.
    """
    turn, extents, _ = np.linalg.svd(holding @ null_space(taken, RANK))
    idle = int(np.sum(extents > RANK * extents[0]))
    return turn, turn[:, idle:].T @ holding @ np.linalg.pinv(taken, RANK)


def with_rotors(model: TorqueModel) -> TorqueModel:
    """The model with the inertia of a rotor at every joint."""
    have = {effect.joint for effect in model.effects if isinstance(effect, RotorInertia)}
    missing = (j for j in range(model.robot.n) if j not in have)
    return model.with_effects(*(RotorInertia(j) for j in missing))


@dataclass(frozen=True)
class Trials:
    """A model and a log, of which changes are tried.

    Attributes:
        model: Of the torque, with all that every fit may have but the constants.
        recordings: Of all roles, processed.
    """

    model: TorqueModel
    recordings: tuple[ProcessedRecording, ...]

    @cached_property
    def as_logged(self) -> Outcome:
        """The log as it is."""
        return self._laid_out[self._none.of_columns].fit(self._none)

    @cached_property
    def without_constants(self) -> Outcome:
        """The log as it is by the model alone."""
        logged = NormalEquations.of(self._logged_factors, self._friction, constants=False)
        return logged.fit(self._none)

    def equations(self, changes: Sequence[Change]) -> list[NormalEquations]:
        """Of each change; those with the same columns are laid out once, and kept."""
        known = self._laid_out
        alike = {c.of_columns: c for c in changes if c.of_columns not in known}
        for columns, change in told(tuple(alike.items()), "causes looked into"):
            factors = self._factors(change)
            known[columns] = NormalEquations.of(factors, self._friction, constants=True)
        return [known[change.of_columns] for change in changes]

    def independent(self, outcome: Outcome) -> Float[ndarray, " joints"]:
        """Independent samples of each torque: its rows over those that its residual is correlated over.

        What a model lacks lasts longer than noise: so much less the rows of such a joint tell.
        """
        left = [self._left(recording, outcome) for recording in self.recordings]
        rows = sum(len(own) for own in left)
        most = sum(2 * r.bandwidth * len(r) / r.rate for r in self.recordings)
        lengths = [correlation_length([own[:, j] for own in left]) for j in range(left[0].shape[1])]
        return outcome.change.by_column(np.minimum(rows / np.array(lengths), most))

    @cached_property
    def _friction(self) -> Bool[ndarray, " parameters"]:
        return np.array([p == "friction" for e in self.model.effects for p in e.parts])

    @property
    def _none(self) -> Change:
        return Change.none(self.model.robot.n)

    @cached_property
    def _logged_factors(self) -> list[Float[ndarray, "_ width"]]:
        return self._factors(self._none)

    @cached_property
    def _laid_out(self) -> dict[Hashable, NormalEquations]:
        """By columns; each as large as so many parameters squared a joint, whatever the rows."""
        logged = NormalEquations.of(self._logged_factors, self._friction, constants=True)
        return {self._none.of_columns: logged}

    def _factors(self, change: Change) -> list[Float[ndarray, "_ width"]]:
        """Of each joint's rows [columns | 1 | velocity | torques], their mean over samples."""
        factors: list[Float[ndarray, "_ width"]] = []
        for recording in self.recordings:
            for place, columns in self._pieces(recording, change):
                tau = recording.tau[place]
                ones = np.ones((len(tau), 1))
                dq = change.motion(recording.motion[place]).dq
                rows = [
                    np.column_stack([columns[:, j], ones, dq[:, j], tau])
                    for j in range(tau.shape[1])
                ]
                before = factors or [own[:0] for own in rows]
                factors = [factor_of(pair) for pair in zip(before, rows, strict=True)]
        samples = sum(len(recording) for recording in self.recordings)
        return [factor / np.sqrt(samples) for factor in factors]

    def _left(
        self, recording: ProcessedRecording, outcome: Outcome
    ) -> Float[ndarray, "samples joints"]:
        n = self.model.robot.n
        parameters, constants = outcome.parameters[:-n], outcome.parameters[-n:]
        left = outcome.change.torque(recording.tau) - constants
        for place, columns in self._pieces(recording, outcome.change):
            left[place] -= columns @ parameters
        return left

    def _pieces(
        self, recording: ProcessedRecording, change: Change
    ) -> Iterator[tuple[slice, Float[ndarray, "samples joints columns"]]]:
        meant = change.model(self.model)
        return recording.pieces(
            lambda motion: meant.columns(change.motion(motion)), remembers=meant.remembers
        )
