"""The base model's fit with its own noise, off which the noise floor is read."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import (
    sign_terms,
    widths_of,
    with_uncertain_sign,
)
from oed.estimation.noise_floor.autoregression import Autoregression
from oed.estimation.noise_floor.linear_fit import LinearFit, fit_model
from oed.estimation.noise_floor.noise_floor import (
    NoiseFloor,
    differences,
    floor_from_repetitions,
    floor_from_smooth_fit,
    repetition_samples,
    repetition_series,
)
from oed.estimation.noise_floor.rich_columns import forget, lay_out, model_columns
from oed.estimation.noise_floor.rich_fit import RichFit, rich_fit
from oed.estimation.noise_floor.sign_width import with_fitted_sign
from oed.estimation.noise_floor.weighted_rows import Rows, weigh
from oed.experiment.preparation.direction import certainty, trusted_samples
from oed.experiment.preparation.encoder_steps import fine_encoder_torque
from oed.experiment.preparation.excerpts import excerpts
from oed.experiment.preparation.prepared import Prepared
from oed.parallel_map import parallel_map

REFITS = 2  # of the base model with the noise that it left
LEAST_TRUSTED = 0.05  # of a joint's rows
LEAST_FREEDOM = 3  # degrees that a smooth fit leaves to the noise of a joint
# A deviation is known from them within a per cent, and a rich fit holds some hundred columns of all.
FLOOR_ROWS = 10_000
ROUGH_FREEDOM = 20  # where only the rows of a rougher fit leave any: known within a sixth


@dataclass(frozen=True)
class Baseline:
    """The model before any addition.

    Attributes:
        model: Its Coulomb friction knows how uncertain the velocity's sign is.
        columns: Base columns of the model.
        floor: Noise of each joint.
        coulomb: (n,) height of the friction steps [N m].
        least_widths: Of each Coulomb term's sign, as encoder noise alone has it [rad/s].
    """

    model: TorqueModel
    columns: Int[ndarray, " base"]
    floor: NoiseFloor
    coulomb: Float[ndarray, " joints"]
    least_widths: tuple[float, ...]

    def with_model(
        self,
        model: TorqueModel,
        prepared: tuple[Prepared, ...],
        known: Sequence[Float[ndarray, "_ joints"]] | None = None,
    ) -> Baseline:
        """The same columns with other shapes, and the noise that these leave.

        Args:
            model: With the other shapes.
            prepared: The estimation recordings.
            known: Torque of additions on the fine grid, one array a recording [N m].
        """
        fit = fit_model(model, self.columns, self.rows(prepared), known)
        floor = _read_floor(fit, prepared, known)
        return dataclasses.replace(self, model=model, floor=floor, coulomb=_coulomb_of(fit))

    def certainty(self, prepared: Sequence[Prepared]) -> list[Float[ndarray, "_ joints"]]:
        """Weights of the errors of recordings: below one where the direction is uncertain."""
        return [certainty(p, self.coulomb, self.floor.deviation) for p in prepared]

    def noise_share(self, prepared: Sequence[Prepared]) -> list[Float[ndarray, "_ joints"]]:
        """Of the variance of each valid row's error; the rest is friction of no known direction.

        Errors of a perfect model, with these for weights, have about the noise's deviation.
        """
        return [weights**2 for weights in self.certainty(prepared)]

    def rows(self, prepared: tuple[Prepared, ...], scales: tuple[float, ...] | None = None) -> Rows:
        """White rows of any recordings of the same robot."""
        return weigh(prepared, self.floor.noise, self.coulomb, scales, self.floor.dilution)


def find_baseline(
    model: TorqueModel, prepared: tuple[Prepared, ...], noise: Baseline | None = None
) -> Baseline:
    """Fit the base model roughly, and read the noise off what it leaves.

    Args:
        model: Rigid body and friction.
        prepared: The estimation recordings; of very long ones stretches tell as much.
        noise: Of another model of the same recordings, whose noise and steps are taken over: two
            models' errors are held against each other with the same weights; none if None.

    Raises:
        ValueError: If they are too short, or no row of a joint shows noise.
    """
    prepared = excerpts(prepared, FLOOR_ROWS)
    sharp = with_uncertain_sign(model, prepared[0].sign_noise)
    columns = np.sort(base_parameters(model).columns)
    if noise is not None:
        turned = with_fitted_sign(sharp, columns, noise.rows(prepared))
        return dataclasses.replace(
            noise, model=turned, columns=columns, least_widths=tuple(widths_of(sharp))
        )
    rough = fit_model(sharp, columns, _white(prepared))
    rough = fit_model(sharp, columns, _scaled(prepared, rough))
    found = Baseline(
        sharp, columns, _read_floor(rough, prepared), _coulomb_of(rough), tuple(widths_of(sharp))
    )
    # What encoder noise does to the torque depends on the inertias, and a fit that does not yet
    # know the noise's colour takes them for too small.
    for _ in range(REFITS):
        found = found.with_model(with_fitted_sign(sharp, columns, found.rows(prepared)), prepared)
    forget()
    silent = np.flatnonzero(found.floor.deviation <= 0)
    if len(silent):
        names = ", ".join(model.robot.joint_names[j] for j in silent)
        raise ValueError(
            f"{names}: no row tells the noise of the torque from the direction of friction; look at the "
            "torque columns with oed check"
        )
    return found


def _coulomb_of(fit: LinearFit) -> Float[ndarray, " joints"]:
    """Height of each joint's friction step as the fit has it [N m]."""
    heights = np.zeros(fit.model.robot.n)
    full = fit.full_parameters()
    for _, column, sign in sign_terms(fit.model):
        heights[sign.joint] = abs(full[column])
    return heights


def _fine_residual(fit: LinearFit, recording: Prepared) -> Float[ndarray, "samples joints"]:
    """Unfiltered residual of a fit on a recording's fine grid [N m]."""
    return recording.fine_torque - fit.model.torque(fit.full_parameters(), recording.motion)


def _white(prepared: tuple[Prepared, ...]) -> Rows:
    joints = prepared[0].torque.shape[1]
    scales = np.sqrt(np.mean(np.concatenate([p.torque for p in prepared]) ** 2, axis=0))
    noise = tuple(Autoregression.white(s) for s in scales)
    ones = np.ones((sum(p.rows for p in prepared), joints))
    return Rows(prepared, noise, (1.0,) * len(prepared), ones)


def _scaled(prepared: tuple[Prepared, ...], rough: LinearFit) -> Rows:
    scales = [noise.scale for noise in rough.rows.noise]
    left = np.sqrt(np.mean(rough.residual**2, axis=1))
    noise = tuple(Autoregression.white(s * r) for s, r in zip(scales, left, strict=True))
    return Rows(prepared, noise, rough.rows.scales, rough.rows.weights)


def _read_floor(
    fit: LinearFit,
    prepared: tuple[Prepared, ...],
    known: Sequence[Float[ndarray, "_ joints"]] | None = None,
) -> NoiseFloor:
    known = [np.zeros_like(p.fine_torque) for p in prepared] if known is None else known
    if any(p.period is not None for p in prepared):
        return _repetition_floor(fit, prepared, known)
    return _smooth_floor(fit, prepared, known)


def _repetition_floor(
    rough: LinearFit, prepared: tuple[Prepared, ...], known: Sequence[Float[ndarray, "_ joints"]]
) -> NoiseFloor:
    pairs = zip(prepared, known, strict=True)
    residuals = [(p, _fine_residual(rough, p) - k) for p, k in pairs if p.period is not None]
    repeated = [p for p, _ in residuals]
    series = [repetition_series(p, residual) for p, residual in residuals]
    # Periods may differ from recording to recording.
    apart = np.concatenate([differences(s).reshape(-1, s.shape[2]) for s in series])
    deviation = np.std(apart, axis=0)
    coulomb = _coulomb_of(rough)
    trusted = []
    for p in repeated:
        fine = np.stack(
            [trusted_samples(p, j, coulomb[j], deviation[j]) for j in range(len(coulomb))], axis=1
        )
        trusted.append(fine[repetition_samples(p)])
    errors = fine_encoder_torque(partial(rough.model.torque, rough.full_parameters()), repeated)
    rounding = [repetition_series(p, e) for p, e in zip(repeated, errors, strict=True)]
    band = repeated[0].band
    return floor_from_repetitions(series, trusted, band.analysis_rate, rounding, cutoff=band.cutoff)


def _smooth_floor(
    fit: LinearFit, prepared: tuple[Prepared, ...], known: Sequence[Float[ndarray, "_ joints"]]
) -> NoiseFloor:
    """What a rich fit of each joint leaves of the torque less `known`."""
    coulomb = _coulomb_of(fit)
    pairs = zip(prepared, known, strict=True)
    torque = np.concatenate([p.torque - p.band.apply(k) for p, k in pairs])
    own = model_columns(fit, prepared)
    base = len(fit.columns)
    rough = torque - own[:, :, :base] @ fit.parameters[:base]

    def of_joint(j: int) -> tuple[RichFit, Bool[ndarray, " rows"]]:
        rich = partial(rich_fit, fit, prepared, j, own=own[:, j], torque=torque[:, j])
        trust = partial(_trusted_rows, prepared, j, float(coulomb[j]))
        trusted = trust(float(np.std(rough[:, j])))
        first = rich(trusted=trusted, enriched=False)
        # A badly timed reversal stands out ever more clearly as the fit improves.
        surest = trust(float(np.std(first.residual[trusted])))
        found = rich(trusted=surest)
        if _freedom(found, surest) < LEAST_FREEDOM:
            rougher = rich(trusted=trusted)
            if _freedom(rougher, trusted) >= ROUGH_FREEDOM:
                return rougher, trusted
        return found, surest

    lay_out(prepared)
    found, seen = zip(*parallel_map(of_joint, range(fit.model.robot.n)), strict=True)
    residual, trusted = (np.stack(x, axis=1) for x in ([f.residual for f in found], seen))
    deviation = np.array([np.std(f.residual[rows]) for f, rows in zip(found, seen, strict=True)])
    for j, (f, rows) in enumerate(zip(found, seen, strict=True)):
        if _freedom(f, rows) < LEAST_FREEDOM:
            raise ValueError(
                f"joint {j + 1}: {rows.sum()} samples in the analysis band for {f.rank} functions of "
                f"the motion: too few to tell noise from it; record longer, or repeat the motion"
            )
    colours = [f.colour for f in found]
    noise = np.array([c.mean_square for c in colours])
    freedom = deviation**2 / np.where(noise > 0, noise, np.inf)
    dilution = np.array([c.correlated_rows for c in colours])
    ends = np.cumsum([p.rows for p in prepared])[:-1]
    left, seen = np.split(residual, ends), np.split(trusted, ends)
    rate = prepared[0].band.analysis_rate
    return floor_from_smooth_fit(left, seen, freedom, dilution, rate)


def _freedom(fit: RichFit, fitted: Bool[ndarray, " rows"]) -> int:
    """Degrees that a fit leaves to the noise of the rows that it was made on."""
    return int(fitted.sum()) - fit.rank


def _trusted_rows(
    prepared: Sequence[Prepared], joint: int, coulomb: float, deviation: float
) -> Bool[ndarray, " rows"]:
    trusted = []
    for recording in prepared:
        fine = trusted_samples(recording, joint, coulomb, deviation)
        rows = fine[:: recording.band.factor]
        # Of a joint that hardly leaves its reversals all rows must do.
        trusted.append(rows if rows.mean() > LEAST_TRUSTED else np.ones_like(rows))
    return np.concatenate(trusted)
