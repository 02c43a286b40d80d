"""How far each model of a calibration is from the arm when it is simulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.commands.configurations import ModelName, Prior
from oed.commands.feasible import WANTED, estimate
from oed.commands.from_data_set import prepare as prepare_estimate
from oed.commands.telling import say
from oed.dynamics.effects import RigidBody
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.feasible.calibration import FeasibleSettings
from oed.estimation.feasible.feasible_set import FeasibleSet
from oed.estimation.feasible.reference import file_inertials
from oed.estimation.rollout import HORIZONS, NotSimulated, Track, roll_out
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.settings import choose_settings
from oed.experiment.recording import HELD_OUT, Role
from oed.experiment.stretches import split_at_gaps
from oed.export.model_file import load_model

SMOKE_WEIGHT = 1e-3  # of the pull to plausible bodies, in place of a cross-validation
BASE_OF_BODIES = "base, bodies that exist"
FEWEST_RESAMPLES, FEW_POSES = 2, 100
# Of a model that no simulation has.
NOTHING: dict[str, object] = {
    "flange_mm": None,
    "joint": None,
    "windows": 0,
    "lost": 0,
    "not_simulated": None,
}
Models = Mapping[str, tuple[TorqueModel, Float[ndarray, " p"]]]


def rollouts(dataset: DataSet, models: Models, *, windows: int) -> dict[str, object] | None:
    """Errors of each model's simulation, as calibration.json has them; None if logs are too short.

    Args:
        dataset: Its held-out recordings are followed.
        models: By name, each with its parameters.
        windows: Most of them a recording.
    """
    tracks = held_out_tracks(dataset)
    if not tracks:
        return None
    found = {}
    for name, (model, parameters) in models.items():
        say(f"simulating {name}")
        try:
            result = roll_out(model, parameters, tracks, windows=windows)
        except NotSimulated as error:
            found[name] = NOTHING | {"not_simulated": str(error)}
            continue
        found[name] = NOTHING | {
            "flange_mm": 1000 * result.flange,
            "joint": result.joint,
            "windows": result.windows,
            "lost": result.lost,
        }
    return {"horizons": list(HORIZONS), "models": found}


def held_out_tracks(
    dataset: DataSet, *, longest: float = HORIZONS[-1], roles: Sequence[Role] = HELD_OUT
) -> list[Track]:
    """Recordings that were not fitted and are long enough for the longest horizon [s]."""
    settings = choose_settings(dataset.recordings)
    long = [
        recording
        for recording in split_at_gaps(dataset).recordings
        if recording.role in roles and recording.duration > longest + 2 * settings.band.lead
    ]
    # Each by itself, in the time of its own log.
    return [
        Track(prepare((recording,), settings)[0].motion, recording.t, recording.tau)
        for recording in long
    ]


def models_in(out: Path, dataset: DataSet) -> Models:
    """The robot file's bodies alone, and what each step of a calibration left."""
    robot = dataset.robot
    bare = (TorqueModel(robot, (RigidBody(robot),)), np.array(robot.parameters))
    steps = {"base": "identify", "augmented": "diagnosis", "feasible": "feasible"}
    loaded = {name: load_model(out / folder / "model.json") for name, folder in steps.items()}
    return {"robot file": bare} | {k: (m.torque_model, m.parameters) for k, m in loaded.items()}


def base_of_bodies(
    dataset: DataSet, name: ModelName | None, prior: Prior, *, smoke: bool, seed: int
) -> tuple[TorqueModel, Float[ndarray, " p"]]:
    """The base model with bodies that can exist, beside which what was found is to be judged.

    Least squares leaves what the data do not determine at zero, and such an arm has no simulation.

    Args:
        dataset: To estimate from.
        name: Of the base model; as the data have it if None.
        prior: As of `oed feasible`.
        smoke: Do less, to see that it works.
        seed: Of everything random.
    """
    prepared = prepare_estimate(dataset, model=name)
    settings = FeasibleSettings(
        demands=FeasibleSet.of(prepared.model),
        inertials=file_inertials(dataset.robot, wanted=WANTED[prior]),
        weight=SMOKE_WEIGHT if smoke else None,
        resamples=FEWEST_RESAMPLES,  # its intervals are not shown
        poses=FEW_POSES,
        seed=seed,
    )
    found = estimate(prepared, settings).estimate
    return found.model, found.parameters
