"""Commands that start from a model or a robot file: oed export and cross-check."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from oed.commands.configurations.command import Command
from oed.commands.options import OutFolder, Range, Rate, Seed

# With the hundred parameters of seven joints, samples.json then takes half of what is read as JSON.
MOST_SAMPLES = 1e4
MOST_STATES = 1e5  # random states a robot; seven joints take a minute and a gigabyte


@dataclass(frozen=True, kw_only=True)
class Export(Command):
    """Write a found model as something that runs: a predictor, a robot file, a simulation.

    Leaves the files of each form and export.json, and says which effects a form cannot have and why.

    Attributes:
        model: A model.json, or the folder that holds it.
        to: Forms: numpy, casadi or c (torque of a motion, for a controller), urdf, sdf or mjcf (robot
            files), mujoco or drake (simulations with all effects), ros2 (parameters), or one that
            was registered from outside.
        out: Folder for the files.
        rate: Rate at which a controller or a simulation asks for torque [Hz].
        samples: Number of models to draw from the covariance, to randomise a simulation with:
            samples.json and randomisation.json.
        seed: Seed of these draws.
    """

    model: Annotated[Path, tyro.conf.Positional]
    to: tuple[str, ...] = ()
    out: OutFolder
    rate: Rate = 1000.0
    samples: Annotated[int, Range(0.0, MOST_SAMPLES)] = 0
    seed: Seed = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.to and not self.samples:
            raise ValueError("--to: name at least one form, such as mujoco")


@dataclass(frozen=True, kw_only=True)
class CrossCheck(Command):
    """Compare our torques with Drake's and Pinocchio's on a robot file.

    Attributes:
        robots: Robot files, or builtin:NAME.
        out: Folder for the table; printed only if not given.
        states: Number of random states for each robot.
        seed: Seed of the states.
    """

    robots: Annotated[tuple[str, ...], tyro.conf.Positional]
    out: OutFolder | None = None
    states: Annotated[int, Range(1.0, MOST_STATES)] = 1000
    seed: Seed = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.robots:
            raise ValueError("name at least one robot file")
