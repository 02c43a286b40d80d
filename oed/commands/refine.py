"""`oed calibrate --refine rollout`: parameters with which a simulation stays near the measured motion."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.stats import chi2

from oed.commands.from_data_set import processing
from oed.commands.rollouts import held_out_tracks
from oed.commands.telling import say
from oed.diagnosis.inference.errors import Predictor
from oed.errors import NoUsableResult
from oed.estimation.rollout import HORIZONS, NotSimulated, roll_out
from oed.estimation.rollout_fit import LENGTH, refine_by_rollout
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.recording import HELD_OUT, Role
from oed.export.bodies import calibrated_robot
from oed.export.model import Model
from oed.export.samples import FeasibleRegion, half_covariance

SURE = 0.95  # of a distance between both fits that the covariance allows


def refine(dataset: DataSet, model: Model, *, windows: int) -> tuple[Model | None, dict]:
    """The refined model, None where it is not accepted; and the record of it.

    It is accepted if on the validation recordings neither the torque's error nor a simulation's, after
    any horizon, is larger. The test recordings report.

    Args:
        dataset: The recordings.
        model: Of possible bodies, with its covariance.
        windows: Most of a recording that are simulated to judge.
    """
    record: dict = {"accepted": False, "reason": "", "errors": []}
    try:
        refined, fitted = _proposed(dataset, model)
        record |= fitted
        calibrated_robot(refined)
        errors = [_errors(dataset, model, refined, role, windows) for role in HELD_OUT]
    except (NoUsableResult, NotSimulated) as error:
        return None, record | {"reason": str(error)}
    record["errors"] = [row for row in errors if row is not None]
    judge = next((row for row in record["errors"] if row["role"] == "validation"), None)
    reason = _against(judge)
    return (None if reason else refined), record | {"accepted": not reason, "reason": reason}


def _proposed(dataset: DataSet, model: Model) -> tuple[Model, dict]:
    """The model with other parameters, and how far they are from those of inverse dynamics."""
    if model.covariance is None:
        raise NoUsableResult("the model has no covariance: oed feasible leaves one")
    half, region = half_covariance(model.covariance), FeasibleRegion.of(model)
    say("fitting simulations to the measured motion")
    fit = refine_by_rollout(
        model.torque_model,
        model.parameters,
        half,
        held_out_tracks(dataset, longest=LENGTH, roles=("estimation",)),
        weights=region.weights,
        bounds=region.bounds,
    )
    origin = dataclasses.replace(
        model.origin, method=f"{model.origin.method}; refined by rollout ({fit.status})"
    )
    record = {
        "windows": fit.windows,
        "status": fit.status,
        "distance": fit.distance,
        "directions": len(fit.shift),
        "allowed": float(chi2.ppf(SURE, len(fit.shift))),
    }
    return dataclasses.replace(model, parameters=fit.parameters, origin=origin), record


def _errors(
    dataset: DataSet, before: Model, after: Model, role: Role, windows: int
) -> dict[str, object] | None:
    """Both models on the recordings of a role; None where none is long enough for any horizon."""
    horizons, tracks = (), []
    for count in range(len(HORIZONS), 0, -1):
        horizons = HORIZONS[:count]
        tracks = held_out_tracks(dataset, longest=horizons[-1], roles=(role,))
        if tracks:
            break
    if not tracks:
        return None
    flanges = [
        roll_out(m.torque_model, m.parameters, tracks, horizons=horizons, windows=windows).flange
        for m in (before, after)
    ]
    rows = [p for p in prepare(dataset.recordings, processing(dataset)) if p.role == role]
    torques = [_rms(m, rows) for m in (before, after)]
    ratio = np.sqrt(np.mean((torques[1] / torques[0]) ** 2))
    return {
        "role": role,
        "horizons": horizons,
        "torque_ratio": float(ratio),
        "flange_mm_before": 1000 * flanges[0],
        "flange_mm_after": 1000 * flanges[1],
    }


def _rms(model: Model, rows: Sequence[Prepared]) -> Float[ndarray, " joints"]:
    predictor = Predictor(model.torque_model, model.parameters)
    errors = np.concatenate([predictor.errors(p) for p in rows])
    return np.sqrt(np.mean(errors**2, axis=0))


def _against(judge: dict | None) -> str:
    """Why a refined model is not accepted; empty if it is."""
    if judge is None:
        return "no validation recording is long enough to judge it"
    if judge["torque_ratio"] > 1:
        return f"the torque's error on validation is {judge['torque_ratio']:.4g} times that before"
    pairs = zip(judge["horizons"], judge["flange_mm_before"], judge["flange_mm_after"], strict=True)
    for horizon, old, new in pairs:
        if new > old:
            return f"the simulation of validation is {new:.3g} mm off after {horizon:g} s, before {old:.3g}"
    return ""
