"""What every command can be told: frozen configurations, and nothing that takes time to load.

`oed --help` and shell completion read these classes alone. The names of models and effects stand
here as text; a test holds that they are those of the library.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from oed.commands.options import Seed

ModelName = Literal["standard", "offset", "rotor"]
# Below this velocity the direction of a geared arm's motion is not known to the data; the
# baselines published with the measured sets use the same figure.
SIGN_WIDTH = 0.02  # [rad/s]


@dataclass(frozen=True, kw_only=True)
class Command:
    """What holds for all commands.

    Attributes:
        quiet: Say nothing but what was found and what is wrong.
    """

    quiet: bool = False


@dataclass(frozen=True, kw_only=True)
class DataSetCommand(Command):
    """A command that starts from a data set.

    Attributes:
        data: Folder of the data set.
        out: Folder for the results.
        joints: Names of the joints to identify; all if not given.
        cutoff: Cut-off of the low-pass [Hz]; chosen from the data if not given.
        model: Torque model: rigid body with friction (standard), with constant torques besides
            (offset), or with rotor inertias besides (rotor).
        sign_width: Velocity over which Coulomb friction turns [rad/s].
        smoke: Do less, to see that it works.
    """

    data: Annotated[Path, tyro.conf.Positional]
    out: Path
    joints: tuple[str, ...] = ()
    cutoff: float | None = None
    model: ModelName = "rotor"
    sign_width: float = SIGN_WIDTH
    smoke: bool = False

    def __post_init__(self) -> None:
        _refuse_empty(self.out)


@dataclass(frozen=True, kw_only=True)
class Identify(DataSetCommand):
    """Estimate the dynamic parameters of an arm, with intervals, and validate them.

    Leaves estimate.json, parameters.csv and report.html.

    Attributes:
        robust: Use Huber's loss in place of least squares.
    """

    robust: bool = False


@dataclass(frozen=True, kw_only=True)
class Feasible(DataSetCommand):
    """Estimate parameters that belong to real bodies, and write URDF, SDF and MJCF with them.

    Leaves estimate.json, parameters.yaml, calibrated_robot.urdf, .sdf, .xml and report.html. Each
    robot file is loaded again and its torques are compared.

    Attributes:
        prior: What is pulled to: the inertials of the robot's file (file), bodies of the size of
            the links (neutral), or the former where they are no placeholders (auto).
        kind: Of that pull.
        weight: Of that pull; by cross-validation if not given.
        total_mass: Of all moving links [kg], where it is known.
        collision: Each link's mass lies within its collision geometry.
        seed: Of poses and bootstrap.
    """

    prior: Literal["auto", "file", "neutral"] = "auto"
    kind: Literal["entropic", "quadratic"] = "entropic"
    weight: float | None = None
    total_mass: float | None = None
    collision: bool = False
    seed: Seed = 0


@dataclass(frozen=True, kw_only=True)
class Diagnose(Command):
    """Find out what the torque model lacks, add it, and show the error before and after.

    Leaves diagnosis.json, report.html, figures and, where two causes cannot be told apart, the
    motion that tells them apart.

    Attributes:
        data: Folder of the data set.
        out: Folder for the results.
        model: Base model; standard if not given, rotor if the data set declares rotor inertias.
        max_effects: Most effects to add; two a joint if not given, at least four.
        candidates: Effects that may be named; the whole catalogue if not given.
        smoke: Do less, to see that it works.
        seed: Of everything random.
    """

    data: Annotated[Path, tyro.conf.Positional]
    out: Path
    model: ModelName | None = None
    max_effects: int | None = None
    candidates: tuple[str, ...] = ()
    smoke: bool = False
    seed: Seed = 0

    def __post_init__(self) -> None:
        _refuse_empty(self.out)
        if self.max_effects is not None and self.max_effects < 0:
            raise ValueError(
                f"--max-effects {self.max_effects} must not be negative; 0 only tests the model"
            )


@dataclass(frozen=True, kw_only=True)
class CrossCheck(Command):
    """Compare our torques with Drake's and Pinocchio's on a robot file.

    Attributes:
        robots: Robot files, or builtin:NAME.
        out: Folder for the table; printed only if not given.
        states: Random states a robot.
        seed: Of the states.
    """

    robots: Annotated[tuple[str, ...], tyro.conf.Positional]
    out: Path | None = None
    states: int = 1000
    seed: Seed = 0

    def __post_init__(self) -> None:
        if not self.robots:
            raise ValueError("name at least one robot file")


def _refuse_empty(folder: Path) -> None:
    """A path of no characters is the folder at hand, which nobody means."""
    if folder == Path():
        raise ValueError("--out is empty; name a folder")
