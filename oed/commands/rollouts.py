"""How far each model of a calibration is from the arm when it is simulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.commands.telling import say
from oed.dynamics.effects import RigidBody
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.rollout import HORIZONS, SETTLING, Track, roll_out
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.settings import choose_settings
from oed.experiment.recording import HELD_OUT, Role
from oed.experiment.stretches import split_at_gaps
from oed.export.model_file import load_model

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
        result = roll_out(model, parameters, tracks, windows=windows)
        found[name] = {
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
    shortest = longest + 2 * SETTLING
    long = tuple(
        recording
        for recording in split_at_gaps(dataset).recordings
        if recording.role in roles and recording.duration > shortest
    )
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
