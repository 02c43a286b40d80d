"""From a data set to ready settings, for every command that estimates parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.commands.configurations import SIGN_WIDTH, DataSetCommand, ModelName
from oed.commands.telling import say
from oed.dynamics.models import build_model
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.calibration import NOTHING
from oed.estimation.known_torque import KnownTorque
from oed.estimation.velocity_choice import choose_velocity
from oed.experiment.choose_settings import choose_settings
from oed.experiment.dataset import DataSet
from oed.experiment.processing import ProcessingSettings
from oed.experiment.read_dataset import read_dataset
from oed.experiment.stretches import gap_notes, gap_record
from oed.export.model import Model
from oed.export.model_file import NAME, load_model
from oed.export.model_record import ModelFileError


@dataclass(frozen=True)
class Prepared:
    """A data set, what is to be estimated of it, and how its signals are processed.

    Attributes:
        dataset: The data set.
        model: Torque model of its robot.
        settings: Of the signal processing, each with its reason.
        known: Torque that is not to be estimated.
        started: The model that was named by its file; None for a model by name.
    """

    dataset: DataSet
    model: TorqueModel
    settings: ProcessingSettings
    known: KnownTorque = NOTHING
    started: Model | None = None


def prepare(
    data: DataSet | str | Path,
    *,
    joints: Sequence[str] = (),
    model: ModelName | Path = "rotor",
    sign_width: float = SIGN_WIDTH,
    cutoff: float | None = None,
    smoke: bool = False,
) -> Prepared:
    """Read a data set, build its model and choose how to process the one for the other; says why.

    Args:
        data: A data set, or its folder.
        joints: Names of the joints to identify, where a folder is read; all if empty.
        model: Name of the torque model, or a model.json whose effects it has.
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
    started = None
    if isinstance(model, Path):
        started = model_for(dataset, model)
        torque_model, known = started.to_estimate()
    else:
        torque_model, known = build_model(model, dataset.robot, sign_width=sign_width), NOTHING
    settings = choose_settings(dataset)
    if cutoff is not None:
        settings = settings.with_cutoff(cutoff)
    settings = choose_velocity(dataset, torque_model, settings)
    if smoke:
        settings = settings.thinned()
    for reason in settings.reasons:
        say(f"  {reason}")
    return Prepared(dataset, torque_model, settings, known, started)


def model_for(dataset: DataSet, path: Path) -> Model:
    """A model from a file, of the arm that a data set is of.

    Raises:
        ModelFileError: If the file cannot be read, or is of another arm.
    """
    found = load_model(path / NAME if path.is_dir() else path)
    said, meant = found.robot.joint_names, dataset.robot.joint_names
    if said != meant:
        raise ModelFileError(
            f"{path}: its joints are {', '.join(said)}; those of {dataset.name} are {', '.join(meant)}"
        )
    return found


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
