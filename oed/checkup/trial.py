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
from oed.estimation.triangular import triangularise
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.recording import HELD_OUT, Role

Columns = Callable[[Motion], Float[ndarray, "samples joints columns"]]
Rows = tuple[Float[ndarray, "_ joints columns"], Float[ndarray, "_ joints"]]

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
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]], evaluate: Columns
) -> TrialData:
    """Lay a data set out for trials.

    Args:
        recordings: By role; the held-out roles are predicted, or the last third of each estimation
            recording where there is none.
        evaluate: The model's columns at every instant of a motion.
    """
    rows = {
        role: [(recording.columns(evaluate), recording.tau) for recording in group]
        for role, group in recordings.items()
    }
    fitted = rows["estimation"]
    held = [pair for role in HELD_OUT for pair in rows.get(role, [])]
    span = _duration([r for role in HELD_OUT for r in recordings.get(role, ())])
    if not held:
        cuts = [int(FITTED_SHARE * len(tau)) for _, tau in fitted]
        held = [(c[k:], tau[k:]) for (c, tau), k in zip(fitted, cuts, strict=True)]
        fitted = [(c[:k], tau[:k]) for (c, tau), k in zip(fitted, cuts, strict=True)]
        span = (1 - FITTED_SHARE) * _duration(recordings["estimation"])
    basis = _basis([columns for columns, _ in (*fitted, *held)])
    band = recordings["estimation"][0].bandwidth
    return TrialData(_part(fitted, basis, 0.0), _part(held, basis, 2 * band * span), basis.shape[1])


def _duration(recordings: Sequence[ProcessedRecording]) -> float:
    return float(sum(len(recording) / recording.rate for recording in recordings))


def _basis(columns: Sequence[Float[ndarray, "_ joints columns"]]) -> Float[ndarray, "all p"]:
    """Combinations of the columns that differ on the recordings, of one norm each."""
    factor = triangularise(np.concatenate([c.reshape(-1, c.shape[2]) for c in columns]))
    norms = np.linalg.norm(factor, axis=0)
    used = norms > RANK * norms.max()
    _, sizes, right = np.linalg.svd(factor[:, used] / norms[used])
    kept = sizes > RANK * sizes[0]
    basis = np.zeros((len(norms), int(kept.sum())))
    basis[used] = right[kept].T / norms[used][:, None]
    return basis


def _part(pairs: Sequence[Rows], basis: Float[ndarray, "all p"], independent: float) -> Part:
    columns = np.concatenate([c @ basis for c, _ in pairs])
    torque = np.concatenate([tau for _, tau in pairs])
    ones = np.ones((len(torque), 1))
    factors = [
        triangularise(np.column_stack([columns[:, j], ones, torque])) / np.sqrt(len(torque))
        for j in range(torque.shape[1])
    ]
    return Part(np.array(factors), independent)


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
