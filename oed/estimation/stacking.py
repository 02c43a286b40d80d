"""From recordings to the torque equations of an estimate, one band for torque and model."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.dataset import DataSet
from oed.experiment.processing import ProcessedRecording, ProcessingSettings, process
from oed.experiment.recording import ROLES, Recording, Role
from oed.experiment.stretches import LEAST_STRETCH, split_at_gaps

TRIMS_PER_STRETCH = 4.0  # at least half of a stretch between gaps of the log is kept


def process_all(
    dataset: DataSet, settings: ProcessingSettings
) -> dict[Role, tuple[ProcessedRecording, ...]]:
    """All recordings processed, by role; roles without recordings are left out.

    A recording with gaps in its time is processed stretch by stretch.

    Raises:
        ValueError: If there is no recording for estimation, or one is too short.
    """
    dataset = between_gaps(dataset, settings)
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


def between_gaps(dataset: DataSet, settings: ProcessingSettings) -> DataSet:
    """The data set without gaps, stretches short of the settings' trim left out."""
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
