"""The base model's fit with its own noise: where every diagnosis starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.diagnosis.direction import certainty, trusted_samples
from oed.diagnosis.free_form import FreeForm
from oed.diagnosis.free_terms import coordinate
from oed.diagnosis.linear_fit import LinearFit, fit_model, fit_regressor, whitened_regressor
from oed.diagnosis.model_columns import WIDTH_PER_SIGMA, effect_columns, with_uncertain_sign
from oed.diagnosis.noise_floor import (
    NoiseFloor,
    floor_from_free_form,
    floor_from_repetitions,
    repetition_samples,
    repetition_series,
)
from oed.diagnosis.prepare import Prepared
from oed.diagnosis.rows import Rows, weigh
from oed.diagnosis.sign_width import with_fitted_sign
from oed.diagnosis.whitening import Autoregression
from oed.dynamics.effects import Coulomb
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel

REFITS = 2  # of the base model with the noise that it left
ROWS_PER_FREE_COLUMN = 8  # least rows for each column of the rich fit


@dataclass(frozen=True)
class Baseline:
    """The model before any addition.

    Attributes:
        model: Its Coulomb friction knows how uncertain the velocity's sign is.
        columns: Base columns of the model.
        floor: Noise of each joint.
        coulomb: (n,) height of the friction steps [N m].
    """

    model: TorqueModel
    columns: Int[ndarray, " base"]
    floor: NoiseFloor
    coulomb: Float[ndarray, " joints"]

    def with_model(self, model: TorqueModel, prepared: tuple[Prepared, ...]) -> Baseline:
        """The same columns with other shapes, and the noise that these leave."""
        fit = fit_model(model, self.columns, self.rows(prepared))
        return Baseline(model, self.columns, _read_floor(fit, prepared), coulomb_of(fit))

    def certainty(self, prepared: Sequence[Prepared]) -> list[Float[ndarray, "_ joints"]]:
        """Weights of the errors of recordings: below one where the direction is uncertain."""
        return [certainty(p, self.coulomb, self.floor.deviation) for p in prepared]

    def rows(self, prepared: tuple[Prepared, ...], scales: tuple[float, ...] | None = None) -> Rows:
        """White rows of any recordings of the same robot."""
        return weigh(prepared, self.floor.noise, self.coulomb, scales, self.floor.dilution)


def find_baseline(model: TorqueModel, prepared: tuple[Prepared, ...]) -> Baseline:
    """Fit the base model roughly, and read the noise off what it leaves.

    Args:
        model: Rigid body and friction.
        prepared: The estimation recordings.
    """
    sharp = with_uncertain_sign(model, prepared[0].sign_noise)
    columns = np.sort(base_parameters(model).columns)
    flat = _white(prepared)
    rough = fit_regressor(sharp, columns, flat, whitened_regressor(sharp, columns, flat))
    flat = _scaled(prepared, rough)
    rough = fit_regressor(sharp, columns, flat, whitened_regressor(sharp, columns, flat))
    found = Baseline(sharp, columns, _read_floor(rough, prepared), coulomb_of(rough))
    # What encoder noise does to the torque depends on the inertias, and a fit that does not yet
    # know the noise's colour takes them for too small.
    for _ in range(REFITS):
        found = found.with_model(with_fitted_sign(sharp, columns, found.rows(prepared)), prepared)
    return found


def coulomb_of(fit: LinearFit) -> Float[ndarray, " joints"]:
    """Height of each joint's friction step as the fit has it [N m]."""
    heights = np.zeros(fit.model.robot.n)
    full = fit.full_parameters()
    column = 0
    for effect in fit.model.effects:
        if isinstance(effect, Coulomb):
            heights[effect.joint] = abs(full[column])
        column += len(effect.parameters)
    return heights


def fine_residual(fit: LinearFit, recording: Prepared) -> Float[ndarray, "samples joints"]:
    """Unfiltered residual of a fit on a recording's fine grid [N m]."""
    return recording.fine_torque - fit.model.torque(fit.full_parameters(), recording.motion)


def _white(prepared: tuple[Prepared, ...]) -> Rows:
    joints = prepared[0].torque.shape[1]
    scales = np.sqrt(np.mean(np.concatenate([p.torque for p in prepared]) ** 2, axis=0))
    noise = tuple(Autoregression(np.ones(1), max(float(s), 1e-9)) for s in scales)
    ones = np.ones((sum(p.rows for p in prepared), joints))
    return Rows(prepared, noise, (1.0,) * len(prepared), ones)


def _scaled(prepared: tuple[Prepared, ...], rough: LinearFit) -> Rows:
    scales = [noise.scale for noise in rough.rows.noise]
    left = np.sqrt(np.mean(rough.residual**2, axis=1))
    noise = tuple(
        Autoregression(np.ones(1), max(float(s * r), 1e-9))
        for s, r in zip(scales, left, strict=True)
    )
    return Rows(prepared, noise, rough.rows.scales, rough.rows.weights)


def _read_floor(fit: LinearFit, prepared: tuple[Prepared, ...]) -> NoiseFloor:
    has_repetitions = any(p.period is not None for p in prepared)
    return (_repetition_floor if has_repetitions else _free_form_floor)(fit, prepared)


def _repetition_floor(rough: LinearFit, prepared: tuple[Prepared, ...]) -> NoiseFloor:
    repeated = [p for p in prepared if p.period is not None]
    series = [repetition_series(p, fine_residual(rough, p)) for p in repeated]
    deviation = np.std(np.concatenate([np.diff(s, axis=0) for s in series]), axis=(0, 1)) / 2**0.5
    coulomb = coulomb_of(rough)
    trusted = []
    for p in repeated:
        fine = np.stack(
            [trusted_samples(p, j, coulomb[j], deviation[j]) for j in range(len(coulomb))], axis=1
        )
        trusted.append(fine[repetition_samples(p)])
    return floor_from_repetitions(series, trusted)


def rich_columns(
    prepared: tuple[Prepared, ...], fit: LinearFit, joint: int, most: int
) -> list[Float[ndarray, "_ columns"]]:
    """Filtered columns of a rich free-form fit of one joint, one array a recording.

    Splines in the joint's own coordinates and in the others' positions, with and without the
    direction of motion, and the rate of the model torque, which a delay would leave.
    """
    n = fit.model.robot.n
    terms = [
        FreeForm(joint, (coordinate(prepared, "dq", joint, 10),)),
        FreeForm(joint, (coordinate(prepared, "q", joint, 10),)),
        FreeForm(joint, (coordinate(prepared, "q", joint, 6),), directed=True),
        FreeForm(joint, (coordinate(prepared, "ddq", joint, 6),)),
    ]
    for other in range(n):
        if other != joint:
            terms.append(FreeForm(joint, (coordinate(prepared, "dq", other, 5),)))
            terms.append(FreeForm(joint, (coordinate(prepared, "q", other, 5),)))
    while len(terms) > 1 and sum(len(t.parameters) for t in terms) > most:
        terms.pop()
    width = WIDTH_PER_SIGMA * float(prepared[0].sign_noise[joint])
    blocks = []
    for p in prepared:
        torque = fit.model.torque(fit.full_parameters(), p.motion)[:, joint]
        rate = np.gradient(torque, 1 / p.band.rate)
        fine = [effect_columns(t, p.motion, width)[joint] for t in terms]
        fine.append(rate[:, None])
        fine.append((np.abs(torque) * np.tanh(p.motion.dq[:, joint] / max(width, 1e-9)))[:, None])
        blocks.append(p.band.apply(np.concatenate(fine, axis=1)))
    return blocks


def _free_form_floor(rough: LinearFit, prepared: tuple[Prepared, ...]) -> NoiseFloor:
    """What a rich fit of each joint leaves."""
    joints = rough.model.robot.n
    rows = sum(p.rows for p in prepared)
    most = max(10, rows // ROWS_PER_FREE_COLUMN - len(rough.columns) // joints)
    own = [p.band.apply(rough.model.columns(p.motion)[:, :, rough.columns]) for p in prepared]
    rich = [rich_columns(prepared, rough, j, most) for j in range(joints)]
    noise, coulomb = rough.rows.noise, coulomb_of(rough)
    found, freedom = [], np.ones(joints)
    for j in range(joints):
        blocks = [np.concatenate([o[:, j], r], axis=1) for o, r in zip(own, rich[j], strict=True)]
        left, rank = _rich_residual(blocks, [p.torque[:, j] for p in prepared], noise[j])
        freedom[j] = max(0.2, 1 - rank / rows)
        found.append(left)
    residuals = [np.stack(joint_wise, axis=1) for joint_wise in zip(*found, strict=True)]
    deviation = np.std(np.concatenate(residuals), axis=0)
    trusted = [
        np.stack(
            [
                trusted_samples(p, j, coulomb[j], deviation[j])[:: p.band.factor]
                for j in range(joints)
            ],
            axis=1,
        )
        for p in prepared
    ]
    return floor_from_free_form(residuals, trusted, freedom)


def _rich_residual(
    blocks: list[Float[ndarray, "_ columns"]],
    torque: list[Float[ndarray, " _"]],
    noise: Autoregression,
) -> tuple[list[Float[ndarray, " _"]], int]:
    """What a generalised least-squares fit of one joint leaves, unwhitened, and its rank."""
    skip = noise.order
    white = np.concatenate([noise.whiten(b)[skip:] for b in blocks])
    target = np.concatenate([noise.whiten(y[:, None])[skip:, 0] for y in torque])
    norms = np.linalg.norm(white, axis=0)
    norms[norms == 0] = 1.0
    solution, _, rank, _ = np.linalg.lstsq(white / norms, target, rcond=1e-6)
    return [y - b @ (solution / norms) for y, b in zip(torque, blocks, strict=True)], int(rank)
