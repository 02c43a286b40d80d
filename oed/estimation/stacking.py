"""From recordings to the torque equations of an estimate, one band for torque and model."""

from __future__ import annotations

from functools import partial

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.row_pieces import RowPieces, even_pieces
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.processed import ProcessedRecording, processed
from oed.experiment.preparation.settings import ProcessingSettings
from oed.experiment.recording import ROLES, Role


def process_all(
    dataset: DataSet, settings: ProcessingSettings
) -> dict[Role, tuple[ProcessedRecording, ...]]:
    """All recordings processed, by role, all rows alike; roles without recordings are left out.

    A recording with gaps in its time comes in a piece for each stretch between them.

    Raises:
        ValueError: If one is too short.
    """
    prepared = prepare(dataset.recordings, settings)
    found: dict[Role, tuple[ProcessedRecording, ...]] = {
        role: tuple(piece for p in prepared if p.role == role for piece in processed(p))
        for role in ROLES
    }
    return {role: pieces for role, pieces in found.items() if pieces}


def stack(
    model: TorqueModel, base: BaseParameters, recordings: tuple[ProcessedRecording, ...]
) -> tuple[RowPieces, Float[ndarray, "samples joints"]]:
    """Base regressor (sample-major rows) and torque of several recordings (6a), in one band.

    A recording is one piece, or where it is very long several.
    """
    # Each recording by itself: an effect with a memory must not reach over a boundary.
    evaluate, lengths = [], []
    for recording in recordings:
        for place in even_pieces(len(recording), model.robot.n, len(base)):
            evaluate.append(partial(_rows, model, base, recording, place))
            lengths.append(place.stop - place.start)
    torque = np.concatenate([recording.tau for recording in recordings])
    return RowPieces(tuple(evaluate), tuple(lengths), torque.shape[1], len(base)), torque


def _rows(
    model: TorqueModel, base: BaseParameters, recording: ProcessedRecording, place: slice
) -> Float[ndarray, "rows base"]:
    columns = recording.columns(
        lambda motion: base.reduce(model.columns(motion)), remembers=model.remembers, rows=place
    )
    return columns.reshape(-1, len(base))
