"""From a data set to identified parameters: the steps in order, with their defaults."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
from oed.estimation.noise_floor.baseline import Baseline, find_baseline
from oed.estimation.recursive import RecursiveEstimate, recursive_least_squares
from oed.estimation.robust import RobustLoss
from oed.estimation.row_pieces import HELD_BYTES, RowPieces
from oed.estimation.sign_width import choose_sign_widths
from oed.estimation.stacking import stack
from oed.estimation.validation import Validation, validate
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.preparation.processed import ProcessedRecording, processed
from oed.experiment.preparation.settings import ProcessingSettings
from oed.experiment.recording import ROLES, Role

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
        baseline: The noise that no model explains, and where the direction of motion is uncertain;
            None where the recordings are too short to tell.
        known: What was taken off the torque of the recordings before.
    """

    dataset: DataSet
    settings: ProcessingSettings
    model: TorqueModel
    base: BaseParameters
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]]
    estimate: Estimate
    validation: Mapping[Role, Validation]
    baseline: Baseline | None = None
    known: KnownTorque = NOTHING

    @property
    def noise_floor(self) -> Float[ndarray, " joints"] | None:
        """(n,) deviation of the noise in the band [N m]; None where nothing tells."""
        return None if self.baseline is None else self.baseline.floor.deviation

    @property
    def parameters(self) -> Float[ndarray, " parameters"]:
        """Of all columns of the model, regrouped ones at zero."""
        values = np.zeros(len(self.base))
        values[list(self.estimate.columns)] = self.estimate.parameters
        return self.base.to_standard(values)

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
    noise_of: TorqueModel | None = None,
    fixed_signs: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> Calibration:
    """Estimate a model's base parameters and validate them on what was not used.

    Joints are weighted by the noise between repetitions where the recordings have them (Calafiore
    2001, section 4), else by the variance of their residuals; rows by how certain their direction is.

    Args:
        dataset: At least one recording for estimation.
        model: Of the data set's robot.
        settings: Of the signal processing.
        robust: Loss of a robust estimate; least squares if None.
        known: Torque that is not to be estimated.
        noise_of: Model beside which the noise is read off: a data set's own base model where errors of
            several models are compared; `model` if None.
        fixed_signs: Whether friction turns its sign as the model has it, not as the data say.
        say: Told what is done, and how many rows there are where they are more than are held at once.

    Raises:
        ValueError: If there is nothing to estimate from, or a recording is too short.
        TooFewSamples: If there are fewer equations than base parameters.
        OedError: If friction drives every joint, as with torques of the opposite sign.
    """
    measured = prepare(dataset.recordings, settings)
    prepared = known.taken_off(measured, model)
    say("reading the noise off the recordings")
    try:
        noise = None if noise_of is None else find_baseline(noise_of, _training(measured))
        baseline = find_baseline(model, _training(prepared), noise)
    except ValueError:  # too short, or nothing that tells noise from motion
        baseline = None
    recordings = _by_role(prepared, baseline)
    base = base_parameters(model)
    if not fixed_signs:
        model = choose_sign_widths(model, base.columns, recordings["estimation"])
    regressor, torque = stack(model, base, recordings["estimation"])
    if torque.size <= len(base):
        raise TooFewSamples(
            f"{dataset.name}: {len(torque)} samples of {torque.shape[1]} joints after processing "
            f"cannot determine {len(base)} parameters; record longer, or lower the cut-off"
        )
    held_out: dict[Role, RowPieces] = {
        role: stack(model, base, own)[0] for role, own in recordings.items() if role != "estimation"
    }
    say(f"fitting {len(base)} base parameters to {len(torque)} rows of each joint")
    estimate = identify(
        _held(regressor, say),
        torque,
        base.names,
        base.units,
        noise=None if robust else _noise_between_repetitions(baseline),
        robust=robust,
        others=tuple(held_out.values()),
        usual_torque=_usual_torque(recordings),
        certainty=_certainty(recordings["estimation"]),
    )
    dq = np.concatenate([recording.motion.dq for recording in recordings["estimation"]])
    friction = dict(zip(estimate.names, estimate.parameters.tolist(), strict=True))
    check_dissipation(friction, dq, torque, dataset.name)
    predicted: dict[Role, ndarray] = {"estimation": torque - estimate.residual}
    for role, rows in held_out.items():
        predicted[role] = rows.only(estimate.columns).predict(estimate.parameters)
    validation: dict[Role, Validation] = {
        role: validate(
            torques, np.concatenate([r.tau for r in recordings[role]]), _certainty(recordings[role])
        )
        for role, torques in predicted.items()
    }
    return Calibration(
        dataset, settings, model, base, recordings, estimate, validation, baseline, known
    )


def _training(prepared: tuple[Prepared, ...]) -> tuple[Prepared, ...]:
    return tuple(p for p in prepared if p.role == "estimation")


def _held(regressor: RowPieces, say: Callable[[str], None]) -> RowPieces:
    if regressor.size > HELD_BYTES:
        say(
            f"{regressor.rows} rows of {regressor.columns} columns, {regressor.size / 1e9:.1f} GB: "
            f"{HELD_BYTES / 1e9:.1f} GB of them are held, the others are evaluated anew in each pass"
        )
    return regressor.held()


def _by_role(
    prepared: tuple[Prepared, ...], baseline: Baseline | None
) -> dict[Role, tuple[ProcessedRecording, ...]]:
    shares = [None] * len(prepared) if baseline is None else baseline.noise_share(prepared)
    pairs = list(zip(prepared, shares, strict=True))
    found: dict[Role, tuple[ProcessedRecording, ...]] = {
        role: tuple(r for p, share in pairs if p.role == role for r in processed(p, share))
        for role in ROLES
    }
    return {role: recordings for role, recordings in found.items() if recordings}


def _certainty(recordings: tuple[ProcessedRecording, ...]) -> Float[ndarray, "samples joints"]:
    return np.concatenate([recording.certainty for recording in recordings])


def _noise_between_repetitions(baseline: Baseline | None) -> Float[ndarray, " joints"] | None:
    """(n,) variances [N^2 m^2]; None where nothing was repeated, and residuals decide."""
    if baseline is None or baseline.floor.source != "repetitions":
        return None
    return baseline.floor.deviation**2


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
        regressor.only(calibration.estimate.columns).held(),
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
