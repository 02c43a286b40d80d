"""What every study that starts from a data set is told, and its way to ready settings."""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

from oed.dynamics.models import MODELS, build_model
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.velocity_choice import choose_velocity
from oed.experiment.choose_settings import choose_settings
from oed.experiment.dataset import DataSet
from oed.experiment.processing import ProcessingSettings
from oed.experiment.read_dataset import read_dataset
from oed.experiment.stretches import gap_notes, gap_record
from oed.report.output_folder import named_folder
from oed.robot.robot import PINION_RADIUS

# Below this velocity the direction of a geared arm's motion is not known to the data; the
# baselines published with the measured sets use the same figure.
SIGN_WIDTH = 0.02  # [rad/s]
WIDTH_HELP = f"over which friction turns [rad/s]; times {PINION_RADIUS:g} m at prismatic joints"


@dataclass(frozen=True)
class DataSetConfig:
    """What to identify, and where to leave it.

    Attributes:
        data: Folder of the data set.
        out: Folder to leave results in.
        joints: Names of the joints to identify; all if empty.
        cutoff: Of the low-pass [Hz]; chosen from the data if None.
        model: Name of the torque model.
        sign_width: Velocity over which the Coulomb terms change sign at revolute joints [rad/s].
        smoke: Whether to keep only as few samples as carry the band.
    """

    data: Path
    out: Path
    joints: tuple[str, ...] = ()
    cutoff: float | None = None
    model: str = "rotor"
    sign_width: float = SIGN_WIDTH
    smoke: bool = False


def prepare(config: DataSetConfig) -> tuple[DataSet, TorqueModel, ProcessingSettings]:
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


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options that fill a `DataSetConfig`."""
    parser.add_argument("--data", type=Path, required=True, help="folder of the data set")
    parser.add_argument("--out", type=named_folder, required=True, help="folder for the results")
    parser.add_argument("--joints", nargs="+", default=(), help="identify only these joints")
    parser.add_argument("--cutoff", type=float, help="low-pass cut-off [Hz]")
    parser.add_argument("--model", choices=sorted(MODELS), default=DataSetConfig.model)
    parser.add_argument("--sign-width", type=float, default=SIGN_WIDTH, help=WIDTH_HELP)


def say(text: str) -> None:
    """A line for whoever waits."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()
