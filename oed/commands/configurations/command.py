"""What all commands share, and those that start from a data set."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, get_args

import tyro

from oed.commands.options import NotNegative, OutFolder, Positive, check_ranges

ModelName = Literal["standard", "offset", "rotor"]
Prior = Literal["auto", "file", "neutral"]


def check_model(model: ModelName | Path | None) -> None:
    """Refuse a model that is neither a name nor a file.

    Raises:
        ValueError: Naming both.
    """
    if isinstance(model, Path) and not model.exists():
        names = ", ".join(get_args(ModelName))
        raise ValueError(f"--model {model}: neither one of {names} nor a model.json that is there")


@dataclass(frozen=True, kw_only=True)
class Command:
    """What holds for all commands.

    Attributes:
        quiet: Print only the result and what is wrong.
    """

    quiet: bool = False

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True, kw_only=True)
class DataCommand(Command):
    """A command that starts from a data set, or from a log that one is made of.

    Attributes:
        data: Folder of a data set; with --robot, a log, which is imported into OUT/data first.
        out: Folder for the results.
        robot: Where DATA is a log: the robot's file, or builtin:NAME. Use oed import if the log needs
            more options.
        model: Torque model.
    """

    data: Annotated[Path, tyro.conf.Positional]
    out: OutFolder
    robot: str | None = None
    model: ModelName | Path | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check_model(self.model)

    @property
    def inputs(self) -> tuple[Path, ...]:
        """What is read."""
        files = (self.robot, self.model if isinstance(self.model, Path) else None)
        return (self.data, *(Path(file) for file in files if file is not None))


@dataclass(frozen=True, kw_only=True)
class DataSetCommand(DataCommand):
    """A command that estimates from a data set.

    Attributes:
        joints: Names of the joints to identify; all if not given.
        cutoff: Cut-off of the low-pass [Hz]; chosen from the data if not given.
        model: Torque model: rigid body with friction (standard), with constant torques besides
            (offset), or with rotor inertias besides (rotor); if not given, rotor where the data set
            declares gears and determines rotor inertias, else standard.
        sign_width: Velocity over which Coulomb friction changes its sign [rad/s]; from the data if not
            given.
    """

    joints: tuple[str, ...] = ()
    cutoff: Positive | None = None
    model: ModelName | None = None  # pyright: ignore[reportIncompatibleVariableOverride]
    sign_width: NotNegative | None = None
