"""From a data set to identified parameters: the steps in order, with their defaults."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.signal import welch

from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.errors import OedError
from oed.estimation.estimate import Estimate
from oed.estimation.identify import identify
from oed.estimation.recursive import RecursiveEstimate, recursive_least_squares
from oed.estimation.robust import RobustLoss
from oed.estimation.validation import Validation, validate
from oed.estimation.weights import variances_from_repetitions, variances_from_residuals
from oed.experiment.dataset import DataSet
from oed.experiment.processing import ProcessedRecording, ProcessingSettings, process
from oed.experiment.recording import ROLES, Recording, Role
from oed.experiment.signals.repetitions import fold_by_index
from oed.experiment.stretches import LEAST_STRETCH, split_at_gaps

TRIMS_PER_STRETCH = 4.0  # at least half of a stretch between gaps of the log is kept
SPECTRUM_SAMPLES = 512  # a segment of Welch's method: resolution against scatter


class TooFewSamples(OedError):
    """The recordings hold fewer torque equations than the model has parameters."""


@dataclass(frozen=True)
class Calibration:
    """An estimate with all that it came from and all that it was tried on.

    Attributes:
        dataset: The recordings as read.
        settings: How they were processed.
        model: The torque model with all its parameters.
        base: Its base parameters, which the estimate is of.
        recordings: By role, the processed recordings.
        estimate: From the recordings with role estimation.
        validation: By role, how well the estimate predicts; only roles that have recordings.
    """

    dataset: DataSet
    settings: ProcessingSettings
    model: TorqueModel
    base: BaseParameters
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]]
    estimate: Estimate
    validation: Mapping[Role, Validation]

    def torque(self, motion: Motion) -> Float[ndarray, "samples joints"]:
        """Predicted torque [N m or N]."""
        columns = self.base.reduce(self.model.columns(motion))
        return columns[:, :, list(self.estimate.columns)] @ self.estimate.parameters


def calibrate(
    dataset: DataSet,
    model: TorqueModel,
    settings: ProcessingSettings,
    *,
    robust: RobustLoss | None = None,
) -> Calibration:
    """Estimate a model's base parameters and validate them on what was not used.

    Joints are weighted by the torque variance between repetitions where the recordings have
    them (Calafiore 2001, section 4), else by the variance of their residuals.

    Args:
        dataset: At least one recording for estimation.
        model: Of the data set's robot.
        settings: Of the signal processing.
        robust: Loss of a robust estimate; least squares if None.

    Raises:
        ValueError: If there is nothing to estimate from, or a recording is too short.
        TooFewSamples: If there are fewer equations than base parameters.
    """
    recordings = process_all(dataset, settings)
    base = base_parameters(model)
    training = recordings["estimation"]
    regressor, torque = stack(model, base, training)
    if torque.size <= len(base):
        raise TooFewSamples(
            f"{dataset.name}: {len(torque)} samples of {torque.shape[1]} joints after processing "
            f"cannot determine {len(base)} parameters; record longer, or lower the cut-off"
        )
    estimate = identify(
        regressor,
        torque,
        base.names,
        base.units,
        noise=None if robust else repetition_noise(training),
        robust=robust,
        segments=tuple(len(recording) for recording in training),
    )
    validation = {}
    for role, held in recordings.items():
        role_regressor, measured = stack(model, base, held)
        predicted = estimate.predict(role_regressor).reshape(measured.shape)
        validation[role] = validate(predicted, measured)
    return Calibration(dataset, settings, model, base, recordings, estimate, validation)


def convergence(calibration: Calibration, *, steps: int = 200) -> RecursiveEstimate:
    """How the estimate settled as samples came in (the paper's figure 4).

    Args:
        calibration: Its weights and columns are used.
        steps: Number of points in the history.
    """
    regressor, torque = stack(
        calibration.model, calibration.base, calibration.recordings["estimation"]
    )
    samples, joints = torque.shape
    return recursive_least_squares(
        regressor[:, list(calibration.estimate.columns)],
        torque.ravel(),
        joints,
        noise=calibration.estimate.joint_variances,
        block=joints * max(1, samples // steps),
    )


def residual_spectrum(
    calibration: Calibration,
) -> tuple[Float[ndarray, " frequencies"], Float[ndarray, "frequencies joints"]]:
    """Frequency [Hz] and spectral density [(N m)^2/Hz] of the estimation residual.

    Welch's method within each recording, averaged over recordings by their length.
    """
    training = calibration.recordings["estimation"]
    length = min(SPECTRUM_SAMPLES, *(len(recording) for recording in training))
    ends = np.cumsum([len(recording) for recording in training])[:-1]
    pieces = np.split(calibration.estimate.residual, ends)
    spectra = [welch(piece, training[0].rate, nperseg=length, axis=0) for piece in pieces]
    weights = [len(piece) for piece in pieces]
    return spectra[0][0], np.average([density for _, density in spectra], axis=0, weights=weights)


def choose_velocity(
    dataset: DataSet, model: TorqueModel, settings: ProcessingSettings
) -> ProcessingSettings:
    """Settings with the velocity, differentiated or logged, that the model explains better.

    A logged velocity can be better than a differentiated one (a drive's own sensor, a delay
    of the position) or worse (coarse steps, an observer's lag): the estimation recordings decide,
    by the product of the joints' residual variances.
    """
    if any(recording.dq is None for recording in dataset.recordings):
        return settings
    base = base_parameters(model)
    estimation = _between_gaps(dataset, settings).estimation
    scores = {}
    for source in ("differentiated", "logged"):
        candidate = dataclasses.replace(settings, velocity=source)
        training = tuple(process(recording, candidate) for recording in estimation)
        regressor, torque = stack(model, base, training)
        variances = variances_from_residuals(
            _identifiable(regressor), torque.ravel(), model.robot.n
        )
        scores[source] = float(np.exp(0.5 * np.mean(np.log(variances))))
    best = min(scores, key=scores.__getitem__)
    reason = (
        f"velocity: {best}, the residual of the estimation recordings is {scores[best]:.4g} N m "
        f"(geometric mean over joints) against {max(scores.values()):.4g} N m"
    )
    kept = tuple(line for line in settings.reasons if not line.startswith("velocity:"))
    return dataclasses.replace(settings, velocity=best, reasons=(*kept, reason))


def process_all(
    dataset: DataSet, settings: ProcessingSettings
) -> dict[Role, tuple[ProcessedRecording, ...]]:
    """All recordings processed, by role; roles without recordings are left out.

    A recording with gaps in its time is processed stretch by stretch.

    Raises:
        ValueError: If there is no recording for estimation, or one is too short.
    """
    dataset = _between_gaps(dataset, settings)
    by_role: dict[Role, tuple[Recording, ...]] = {
        role: tuple(r for r in dataset.recordings if r.role == role) for role in ROLES
    }
    if not by_role["estimation"]:
        raise ValueError(f"{dataset.name}: no recording has the role estimation")
    return {
        role: tuple(process(recording, settings) for recording in recordings)
        for role, recordings in by_role.items()
        if recordings
    }


def _between_gaps(dataset: DataSet, settings: ProcessingSettings) -> DataSet:
    shortest = max(LEAST_STRETCH, TRIMS_PER_STRETCH * settings.trim)
    return split_at_gaps(dataset, shortest=shortest)


def stack(
    model: TorqueModel, base: BaseParameters, recordings: tuple[ProcessedRecording, ...]
) -> tuple[Float[ndarray, "rows base"], Float[ndarray, "samples joints"]]:
    """Base regressor (sample-major rows) and torque of several recordings (6a), in one band."""
    # Each recording by itself: an effect with a memory must not reach over a boundary.
    columns = [
        recording.columns(lambda motion: base.reduce(model.columns(motion)))
        for recording in recordings
    ]
    torque = np.concatenate([recording.tau for recording in recordings])
    return np.concatenate(columns).reshape(-1, len(base)), torque


def repetition_noise(
    recordings: tuple[ProcessedRecording, ...],
) -> Float[ndarray, " joints"] | None:
    """Torque variance (n,) between repetitions, None where no recording repeats [N^2 m^2].

    Repetitions are cut to their common length, without those at an end of a recording.
    """
    variances, weights = [], []
    for recording in recordings:
        folded = _folded(recording)
        if folded is not None:
            variances.append(variances_from_repetitions(folded))
            weights.append(folded.shape[0] * folded.shape[1])
    return np.average(variances, axis=0, weights=weights) if variances else None


def _folded(
    recording: ProcessedRecording,
) -> Float[ndarray, "repetitions samples joints"] | None:
    if recording.repetition is None:
        return None
    indices, counts = np.unique(recording.repetition, return_counts=True)
    # The first and the last are cut at an end, and no longer start at the same phase.
    indices, counts = indices[1:-1], counts[1:-1]
    whole = indices[counts >= counts.max(initial=0) - 1]
    if len(whole) < 2:
        return None
    length = counts[np.isin(indices, whole)].min()
    position = np.zeros(len(recording), dtype=int)
    for index in whole:
        members = recording.repetition == index
        position[members] = np.arange(members.sum())
    kept = np.isin(recording.repetition, whole) & (position < length)
    return fold_by_index(recording.tau[kept], recording.repetition[kept])


def _identifiable(regressor: Float[ndarray, "rows base"]) -> Float[ndarray, "rows kept"]:
    """Columns without those that this motion leaves at zero, enough to compare residuals."""
    norms = np.linalg.norm(regressor, axis=0)
    _, singular_values, right = np.linalg.svd(
        np.linalg.qr(regressor[:, norms > 0] / norms[norms > 0], mode="r")
    )
    kept = singular_values > 1e-8 * singular_values[0]
    return regressor[:, norms > 0] / norms[norms > 0] @ right[kept].T
