"""From a data set to ready settings, for every command that estimates parameters."""

from __future__ import annotations

from oed.commands.configurations import DataSetCommand
from oed.commands.telling import say
from oed.dynamics.models import build_model
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.velocity_choice import choose_velocity
from oed.experiment.choose_settings import choose_settings
from oed.experiment.dataset import DataSet
from oed.experiment.processing import ProcessingSettings
from oed.experiment.read_dataset import read_dataset
from oed.experiment.stretches import gap_notes, gap_record


def prepare(config: DataSetCommand) -> tuple[DataSet, TorqueModel, ProcessingSettings]:
    """The data set, the torque model, and how to process the one for the other; says why."""
    say(f"reading {config.data}")
    dataset = read_dataset(config.data, joints=config.joints or None)
    for file, column in dataset.unused:
        say(f"note: {file}: column {column!r} is not used")
    for note in (*dataset.notes, *gap_notes(gap_record(dataset))):
        say(f"note: {note}")
    model = build_model(config.model, dataset.robot, sign_width=config.sign_width)
    settings = choose_settings(dataset)
    if config.cutoff is not None:
        settings = settings.with_cutoff(config.cutoff)
    settings = choose_velocity(dataset, model, settings)
    if config.smoke:
        settings = settings.thinned()
    for reason in settings.reasons:
        say(f"  {reason}")
    return dataset, model, settings
