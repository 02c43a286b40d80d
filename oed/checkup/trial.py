"""The fit of a torque model to a data set as it would be if one thing about it were otherwise.

Each joint's rows, its torque and those of all other joints are kept as one triangular factor (Golub and
Van Loan, Matrix Computations, section 5.3), so that a fit with a sign reversed, two torque columns
exchanged or a factor put right takes milliseconds, however long the recordings.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.estimation.reach import find_reach
from oed.estimation.triangular import factor_of, triangularise
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.recording import HELD_OUT, Role

Columns = Callable[[Motion], Float[ndarray, "samples joints columns"]]

RANK = 1e-8  # of the largest singular value, columns of one norm: beyond it a direction is rounding
FITTED_SHARE = 2 / 3  # of each recording, where none is held out
STEPS = 12  # of the weights, which settle in a few
SETTLED = 1e-3  # relative change of the joints' residuals
LEAST_RESIDUAL = 1e-4  # of the torque: a joint fitted to rounding must not outweigh all others


@dataclass(frozen=True)
class Part:
    """Rows of some recordings, by joint.

    Attributes:
        factors: (n, w, w) triangular factor of each joint's rows [columns | 1 | torques of all n
            joints], of their mean over samples.
        independent: Samples that count as independent: twice the band times the duration.
    """

    factors: Float[ndarray, "joints width width"]
    independent: float


@dataclass(frozen=True)
class Trial:
    """A change of the torque columns, tried as the log's fault.

    Attributes:
        source: (n,) whose column each joint's torque is taken to be.
        gain: (n,) that it is multiplied by.
        offset: Whether each joint may have a constant torque.
    """

    source: Int[ndarray, " joints"]
    gain: Float[ndarray, " joints"]
    offset: bool = False

    @classmethod
    def unchanged(cls, joints: int) -> Trial:
        """The log as it is."""
        return cls(np.arange(joints), np.ones(joints))


@dataclass(frozen=True)
class Outcome:
    """How well a trial predicts what was held out.

    Attributes:
        relative: (n,) rms error of each joint over the rms of its torque.
        deviance: -2 log likelihood of the held-out torque as logged, less a constant: the sum over
            joints of m log(error^2) with m independent samples.
        lost: Directions of the parameters that the fitted rows do not carry to the held-out ones.
    """

    relative: Float[ndarray, " joints"]
    deviance: float
    lost: int


@dataclass(frozen=True)
class TrialData:
    """What every trial with the same positions and gravity shares.

    Attributes:
        fitted: To fit to.
        held: To be predicted.
        columns: p, of the model's columns in a basis without dependences.
    """

    fitted: Part
    held: Part
    columns: int

    @property
    def joints(self) -> int:
        """Number of joints."""
        return len(self.fitted.factors)

    def outcome(self, trial: Trial) -> Outcome:
        """Fit and predict under a trial."""
        joints = range(self.joints)
        rows = [self._rows(self.fitted, trial, j) for j in joints]
        held = [self._rows(self.held, trial, j) for j in joints]
        parameters, lost = _fit(rows, held)
        error = np.array([np.linalg.norm(a @ parameters - b) for a, b in held])
        torque = np.array([np.linalg.norm(b) for _, b in held])
        as_logged = np.maximum(error, LEAST_RESIDUAL * torque) / np.abs(trial.gain)
        usual = np.where(as_logged > 0, as_logged, 1.0)
        relative = np.divide(error, torque, out=np.zeros_like(error), where=torque > 0)
        deviance = 2 * self.held.independent * float(np.sum(np.log(usual)))
        return Outcome(relative, deviance, lost)

    def _rows(
        self, part: Part, trial: Trial, joint: int
    ) -> tuple[Float[ndarray, "width columns"], Float[ndarray, " width"]]:
        factor, p = part.factors[joint], self.columns
        offsets = np.zeros((len(factor), self.joints if trial.offset else 0))
        if trial.offset:
            offsets[:, joint] = factor[:, p]
        torque = trial.gain[joint] * factor[:, p + 1 + trial.source[joint]]
        return np.column_stack([factor[:, :p], offsets]), torque


def trial_data(
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
    evaluate: Columns,
    *,
    remembers: bool,
) -> TrialData:
    """Lay a data set out for trials, a piece of a recording at a time.

    Args:
        recordings: By role; the held-out roles are predicted, or the last third of each estimation
            recording where there is none.
        evaluate: The model's columns at every instant of a motion.
        remembers: Whether an instant's columns depend on those before it.
    """
    has_held = any(recordings.get(role) for role in HELD_OUT)
    fitted, held = _Seen(), _Seen()
    for role in ("estimation", *HELD_OUT):
        for recording in recordings.get(role, ()):
            share = (1.0 if has_held else FITTED_SHARE) if role == "estimation" else 0.0
            for place, columns in recording.pieces(evaluate, remembers=remembers):
                tau = recording.tau[place]
                cut = min(max(int(share * len(recording)) - place.start, 0), len(tau))
                fitted = fitted.with_rows(columns[:cut], tau[:cut])
                held = held.with_rows(columns[cut:], tau[cut:])
    if has_held:
        span = _duration([r for role in HELD_OUT for r in recordings.get(role, ())])
    else:
        span = (1 - FITTED_SHARE) * _duration(recordings["estimation"])
    basis = _basis([*fitted.columns, *held.columns])
    band = recordings["estimation"][0].bandwidth
    return TrialData(
        Part(fitted.in_basis(basis), 0.0),
        Part(held.in_basis(basis), 2 * band * span),
        basis.shape[1],
    )


@dataclass(frozen=True)
class _Seen:
    """Triangular factor of each joint's rows [columns | 1 | torques], and their samples."""

    factors: tuple[Float[ndarray, "_ width"], ...] = ()
    samples: int = 0

    def with_rows(
        self, columns: Float[ndarray, "samples joints all"], tau: Float[ndarray, "samples joints"]
    ) -> _Seen:
        """What has seen these too."""
        ones = np.ones((len(tau), 1))
        rows = [np.column_stack([columns[:, j], ones, tau]) for j in range(tau.shape[1])]
        before = self.factors or [np.zeros((0, row.shape[1])) for row in rows]
        factors = (factor_of(pair) for pair in zip(before, rows, strict=True))
        return _Seen(tuple(factors), self.samples + len(tau))

    @property
    def columns(self) -> tuple[Float[ndarray, "_ all"], ...]:
        """Of each joint, the factor's columns that are the model's."""
        return tuple(factor[:, : -1 - len(self.factors)] for factor in self.factors)

    def in_basis(self, basis: Float[ndarray, "all p"]) -> Float[ndarray, "joints width width"]:
        """Factors of the mean over samples, the model's columns in a basis."""
        own = zip(self.columns, self.factors, strict=True)
        changed = [np.column_stack([c @ basis, factor[:, c.shape[1] :]]) for c, factor in own]
        return np.array([triangularise(rows) for rows in changed]) / np.sqrt(self.samples)


def _duration(recordings: Sequence[ProcessedRecording]) -> float:
    return float(sum(len(recording) / recording.rate for recording in recordings))


def _basis(columns: Sequence[Float[ndarray, "_ all"]]) -> Float[ndarray, "all p"]:
    """Combinations of the columns that differ on the recordings, of one norm each."""
    factor = factor_of(columns)
    norms = np.linalg.norm(factor, axis=0)
    used = norms > RANK * norms.max()
    _, sizes, right = np.linalg.svd(factor[:, used] / norms[used])
    kept = sizes > RANK * sizes[0]
    basis = np.zeros((len(norms), int(kept.sum())))
    basis[used] = right[kept].T / norms[used][:, None]
    return basis


def _fit(
    rows: Sequence[tuple[ndarray, ndarray]], held: Sequence[tuple[ndarray, ndarray]]
) -> tuple[Float[ndarray, " columns"], int]:
    """Least squares with each joint weighted by its residual, and the directions left out of it."""
    torque = np.array([np.linalg.norm(b) for _, b in rows])
    floor = LEAST_RESIDUAL * np.where(torque > 0, torque, 1.0)
    residual = np.maximum(torque, floor)
    parameters, residual = _weighted(rows, residual, floor)
    usual = np.sqrt((torque**2 + np.array([np.linalg.norm(b) for _, b in held]) ** 2) / 2)
    reach = find_reach(_interleaved(rows), [_interleaved(held)], residual, usual)
    if reach.lost:
        parameters, _ = _weighted(rows, residual, floor, reach.prior(len(rows)).factor)
    return parameters, reach.lost


def _weighted(
    rows: Sequence[tuple[ndarray, ndarray]],
    residual: Float[ndarray, " joints"],
    floor: Float[ndarray, " joints"],
    held_at_zero: Float[ndarray, "held columns"] | None = None,
) -> tuple[Float[ndarray, " columns"], Float[ndarray, " joints"]]:
    """Parameters and each joint's residual, which is its weight."""
    count = rows[0][0].shape[1]
    held = np.zeros((0, count)) if held_at_zero is None else held_at_zero
    parameters = np.zeros(count)
    for _ in range(STEPS):
        stacked = np.vstack([*(a / s for (a, _), s in zip(rows, residual, strict=True)), held])
        own = [b / s for (_, b), s in zip(rows, residual, strict=True)]
        target = np.concatenate([*own, np.zeros(len(held))])
        parameters = np.linalg.lstsq(stacked, target, rcond=RANK)[0]
        before = residual
        residual = np.array([np.linalg.norm(a @ parameters - b) for a, b in rows])
        residual = np.maximum(residual, floor)
        if np.all(np.abs(residual - before) < SETTLED * before):
            break
    return parameters, residual


def _interleaved(rows: Sequence[tuple[ndarray, ndarray]]) -> ndarray:
    """Sample-major rows of the joints' factors, of a mean over samples as of one sample each."""
    stacked = np.stack([a for a, _ in rows], axis=1)
    return stacked.reshape(-1, stacked.shape[2]) * np.sqrt(len(stacked))
