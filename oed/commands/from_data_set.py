"""From a data set to ready settings, for every command that estimates parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.commands.configurations import DataSetCommand, LoadCommand, ModelName
from oed.commands.telling import say
from oed.dynamics.effects import RotorInertia, TorqueOffset
from oed.dynamics.models import build_model
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.base_model import choose_base_model
from oed.estimation.calibration import NOTHING
from oed.estimation.known_torque import KnownTorque
from oed.estimation.velocity_choice import choose_velocity
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.settings import ProcessingSettings, choose_settings
from oed.experiment.read_dataset import read_dataset
from oed.experiment.stretches import gap_notes, gap_record
from oed.export.model import Model
from oed.export.model_file import load_model, model_file_at
from oed.export.model_record import ModelFileError


@dataclass(frozen=True)
class Prepared:
    """A data set, what is to be estimated of it, and how its signals are processed.

    Attributes:
        dataset: The data set.
        model: Torque model of its robot.
        settings: Of the signal processing, each with its reason.
        notes: On the data.
        known: Torque that is not to be estimated.
        noise_of: Model beside which the noise is read off; `model` if None.
        fixed_signs: Whether friction turns its sign as the model has it, not as the data say.
        started: The model that was named by its file; None for a model by name.
    """

    dataset: DataSet
    model: TorqueModel
    settings: ProcessingSettings
    notes: tuple[str, ...]
    known: KnownTorque = NOTHING
    noise_of: TorqueModel | None = None
    fixed_signs: bool = False
    started: Model | None = None


def prepare(
    data: DataSet | str | Path,
    *,
    joints: Sequence[str] = (),
    model: ModelName | Path | None = None,
    sign_width: float | None = None,
    cutoff: float | None = None,
) -> Prepared:
    """Read a data set, build its model and choose how to process the one for the other; says why.

    Args:
        data: A data set, or its folder.
        joints: Names of the joints to identify, where a folder is read; all if empty.
        model: Name of the torque model, or a model.json whose effects it has; as drives and data
            have it if None.
        sign_width: Velocity over which Coulomb friction turns [rad/s]; chosen from the data if None.
        cutoff: Of the low-pass [Hz]; chosen from the data if None.

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
    notes = (*dataset.notes, *gap_notes(gap_record(dataset)))
    for note in notes:
        say(f"note: {note}")
    started = model_for(dataset, model) if isinstance(model, Path) else None
    settings = processing(dataset, cutoff=cutoff)
    for reason in settings.reasons:
        say(f"  {reason}")
    own, reason = choose_base_model(dataset, settings)
    say(f"base model {own!r}: {reason}" if model is None else f"base model {model}")
    # Noise is the data's, and the same whichever model is asked for.
    noise_of = None if model in (None, own) else build_model(own, dataset.robot)
    if started is not None:
        torque_model, known = started.to_estimate()
        return Prepared(
            dataset,
            torque_model,
            settings,
            notes,
            known,
            noise_of=noise_of,
            fixed_signs=True,
            started=started,
        )
    name = own if model is None else str(model)
    return Prepared(
        dataset,
        build_model(name, dataset.robot, sign_width=sign_width or 0.0),
        settings,
        notes,
        noise_of=noise_of,
        fixed_signs=sign_width is not None,
    )


def model_name(model: TorqueModel) -> ModelName:
    """Which of the models by name has a model's effects."""
    kinds = {type(effect) for effect in model.effects}
    if TorqueOffset in kinds:
        return "offset"
    return "rotor" if RotorInertia in kinds else "standard"


def processing(dataset: DataSet, *, cutoff: float | None = None) -> ProcessingSettings:
    """How every command processes a data set.

    Args:
        dataset: With recordings for estimation.
        cutoff: Of the low-pass [Hz]; chosen from the data if None.
    """
    settings = choose_settings(dataset.recordings, cutoff=cutoff)
    return choose_velocity(dataset, build_model("standard", dataset.robot), settings)


def model_for(dataset: DataSet, path: Path) -> Model:
    """A model from a file, of the arm that a data set is of.

    Raises:
        ModelFileError: If the file cannot be read, or is of another arm.
    """
    found = load_model(model_file_at(path))
    said, meant = found.robot.joint_names, dataset.robot.joint_names
    if said != meant:
        raise ModelFileError(
            f"{path}: its joints are {', '.join(said)}; those of {dataset.name} are {', '.join(meant)}"
        )
    return found


def prepare_at(folder: Path, config: LoadCommand) -> Prepared:
    """The same for one folder of a command that compares several.

    Args:
        folder: Of a data set.
        config: What holds for all of them.
    """
    return prepare(folder, joints=config.joints, model=config.torque_model, cutoff=config.cutoff)


def held_out_notes(*sets: Prepared) -> tuple[str, ...]:
    """Which data sets hold rows out, for a command that judges nothing by them; a line each."""
    notes = []
    for dataset in (prepared.dataset for prepared in sets):
        rows = [len(r.t) for r in dataset.recordings]
        held_out = sum(len(r.t) for r in dataset.recordings if r.role != "estimation")
        if held_out:
            notes.append(
                f"{dataset.name}: {held_out / sum(rows):.0%} of the rows are held out, and nothing "
                "is judged by them here; with the role estimation for every recording, as of oed import "
                "--roles estimation, intervals are narrower"
            )
    return tuple(notes)


def prepare_for(config: DataSetCommand, data: DataSet | Path | None = None) -> Prepared:
    """The same for a command.

    Args:
        config: What it was told.
        data: What it starts from, where that is not the folder that it was told.
    """
    return prepare(
        config.data if data is None else data,
        joints=config.joints,
        model=config.model,
        sign_width=config.sign_width,
        cutoff=config.cutoff,
    )
