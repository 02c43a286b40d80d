"""From a data set to ready settings, for every command that estimates parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.commands.configurations import SIGN_WIDTH, DataSetCommand, ModelName
from oed.commands.telling import say
from oed.dynamics.models import build_model
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.velocity_choice import choose_velocity
from oed.experiment.choose_settings import choose_settings
from oed.experiment.dataset import DataSet
from oed.experiment.processing import ProcessingSettings
from oed.experiment.read_dataset import read_dataset
from oed.experiment.stretches import gap_notes, gap_record


@dataclass(frozen=True)
class Prepared:
    """A data set, what is to be estimated of it, and how its signals are processed.

    Attributes:
        dataset: The data set.
        model: Torque model of its robot.
        settings: Of the signal processing, each with its reason.
    """

    dataset: DataSet
    model: TorqueModel
    settings: ProcessingSettings


def prepare(
    data: DataSet | str | Path,
    *,
    joints: Sequence[str] = (),
    model: ModelName = "rotor",
    sign_width: float = SIGN_WIDTH,
    cutoff: float | None = None,
    smoke: bool = False,
) -> Prepared:
    """Read a data set, build its model and choose how to process the one for the other; says why.

    Args:
        data: A data set, or its folder.
        joints: Names of the joints to identify, where a folder is read; all if empty.
        model: Name of the torque model.
        sign_width: Velocity over which Coulomb friction turns [rad/s].
        cutoff: Of the low-pass [Hz]; chosen from the data if None.
        smoke: Whether to keep only as few samples as carry the band.

    Raises:
        DataSetError: If the folder holds no data set that can be used.
    """
    if isinstance(data, DataSet):
        dataset = data
    else:
        say(f"reading {data}")
        dataset = read_dataset(data, joints=tuple(joints) or None)
    for file, column in dataset.unused:
        say(f"note: {file}: column {column!r} is not used")
    for note in (*dataset.notes, *gap_notes(gap_record(dataset))):
        say(f"note: {note}")
    torque_model = build_model(model, dataset.robot, sign_width=sign_width)
    settings = choose_settings(dataset)
    if cutoff is not None:
        settings = settings.with_cutoff(cutoff)
    settings = choose_velocity(dataset, torque_model, settings)
    if smoke:
        settings = settings.thinned()
    for reason in settings.reasons:
        say(f"  {reason}")
    return Prepared(dataset, torque_model, settings)


def prepare_for(config: DataSetCommand) -> Prepared:
    """The same for a command."""
    return prepare(
        config.data,
        joints=config.joints,
        model=config.model,
        sign_width=config.sign_width,
        cutoff=config.cutoff,
        smoke=config.smoke,
    )
