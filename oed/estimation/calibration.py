"""From a data set to identified parameters: the steps in order, with their defaults."""

from __future__ import annotations

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
from oed.estimation.dissipation import check_dissipation
from oed.estimation.estimate import Estimate
from oed.estimation.identify import identify
from oed.estimation.known_torque import KnownTorque
from oed.estimation.recursive import RecursiveEstimate, recursive_least_squares
from oed.estimation.repetition_noise import repetition_noise
from oed.estimation.robust import RobustLoss
from oed.estimation.stacking import process_all, stack
from oed.estimation.validation import Validation, validate
from oed.experiment.dataset import DataSet
from oed.experiment.processing import ProcessedRecording, ProcessingSettings
from oed.experiment.recording import Role

NOTHING = KnownTorque()
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
        known: What was taken off the torque of the recordings before.
    """

    dataset: DataSet
    settings: ProcessingSettings
    model: TorqueModel
    base: BaseParameters
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]]
    estimate: Estimate
    validation: Mapping[Role, Validation]
    known: KnownTorque = NOTHING

    def torque(self, motion: Motion) -> Float[ndarray, "samples joints"]:
        """Predicted torque beside what is known [N m or N]."""
        columns = self.base.reduce(self.model.columns(motion))
        return columns[:, :, list(self.estimate.columns)] @ self.estimate.parameters


def calibrate(
    dataset: DataSet,
    model: TorqueModel,
    settings: ProcessingSettings,
    *,
    robust: RobustLoss | None = None,
    known: KnownTorque = NOTHING,
) -> Calibration:
    """Estimate a model's base parameters and validate them on what was not used.

    Joints are weighted by the torque variance between repetitions where the recordings have
    them (Calafiore 2001, section 4), else by the variance of their residuals.

    Args:
        dataset: At least one recording for estimation.
        model: Of the data set's robot.
        settings: Of the signal processing.
        robust: Loss of a robust estimate; least squares if None.
        known: Torque that is not to be estimated.

    Raises:
        ValueError: If there is nothing to estimate from, or a recording is too short.
        TooFewSamples: If there are fewer equations than base parameters.
        OedError: If friction drives every joint, as with torques of the opposite sign.
    """
    recordings = known.taken_off(process_all(dataset, settings), model)
    base = base_parameters(model)
    training = recordings["estimation"]
    regressor, torque = stack(model, base, training)
    if torque.size <= len(base):
        raise TooFewSamples(
            f"{dataset.name}: {len(torque)} samples of {torque.shape[1]} joints after processing "
            f"cannot determine {len(base)} parameters; record longer, or lower the cut-off"
        )
    held_out = {
        role: stack(model, base, held) for role, held in recordings.items() if role != "estimation"
    }
    estimate = identify(
        regressor,
        torque,
        base.names,
        base.units,
        noise=None if robust else repetition_noise(training),
        robust=robust,
        segments=tuple(len(recording) for recording in training),
        others=tuple(rows for rows, _ in held_out.values()),
        usual_torque=_usual_torque(recordings),
    )
    dq = np.concatenate([recording.motion.dq for recording in training])
    friction = dict(zip(estimate.names, estimate.parameters.tolist(), strict=True))
    check_dissipation(friction, dq, torque, dataset.name)
    stacked: dict[Role, tuple[ndarray, ndarray]] = {"estimation": (regressor, torque), **held_out}
    validation = {
        role: validate(estimate.predict(rows).reshape(measured.shape), measured)
        for role, (rows, measured) in stacked.items()
    }
    return Calibration(dataset, settings, model, base, recordings, estimate, validation, known)


def _usual_torque(
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
) -> Float[ndarray, " joints"]:
    """Rms torque of each joint, each role as much; that of the test recordings is not looked at."""
    means = [
        np.mean(np.concatenate([recording.tau for recording in held]) ** 2, axis=0)
        for role, held in recordings.items()
        if role != "test"
    ]
    return np.sqrt(np.mean(means, axis=0))


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
