"""Commands about what an arm carries: oed payload and oed gains."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from oed.commands.configurations.command import Command, ModelName
from oed.commands.options import Mass, OutFolder, Place, Positive


@dataclass(frozen=True, kw_only=True)
class LoadCommand(Command):
    """A command that compares an arm with a load with the arm without.

    Attributes:
        out: Folder for the results.
        frame: Link or frame of the robot's file that holds the load; the flange, or the last link,
            if not given.
        joints: Names of the joints to use; all if not given.
        cutoff: Cut-off of the low-pass [Hz]; chosen from the data if not given.
        torque_model: Torque model of the arm; as oed identify chooses it if not given.
    """

    out: OutFolder
    frame: str = ""
    joints: tuple[str, ...] = ()
    cutoff: Positive | None = None
    torque_model: ModelName | None = None


@dataclass(frozen=True, kw_only=True)
class Payload(LoadCommand):
    """Weigh what an arm carries: mass, centre of mass and inertia, with intervals.

    The arm is known from recordings without the load (--bare), from an earlier model (--model), or else
    from the robot's file, which gives wide intervals. Leaves payload.json, the load as URDF, SDF, MJCF,
    ROS 2 message and URScript, and report.html.

    Attributes:
        loaded: Data set with the load.
        bare: Data set of the same arm without it.
        model: model.json of the arm without it.
    """

    loaded: Path
    bare: Path | None = None
    model: Path | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        _require_two_folders(self.bare, (self.loaded,))


@dataclass(frozen=True, kw_only=True)
class Gains(LoadCommand):
    """Find every joint's N m per A, gear included, from recordings with known loads.

    Leaves gains.json, report.html and, where every gain is determined, drive.toml with the lines for
    dataset.toml. Without a mass only ratios of gains are determined. The exit status is 3 if none is.

    Attributes:
        loaded: Data sets with a load each.
        bare: Data set of the same arm without a load.
        mass: Mass of the load in each data set, or of the one load in all [kg].
        com: Centre of mass of the load in the frame, x y z for each data set or once for all [m];
            estimated if not given.
    """

    loaded: tuple[Path, ...] = ()
    bare: Path | None = None
    mass: tuple[Mass, ...] = ()
    com: tuple[Place, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        _require_two_folders(self.bare, self.loaded)
        count = len(self.loaded)
        if len({folder.resolve() for folder in self.loaded}) < count:
            raise ValueError("--loaded: names a data set twice; its rows would count twice")
        if self.bare is None and count < 2:
            raise ValueError(
                "--bare: name a recording of the bare arm, or two with different loads"
            )
        if self.mass and len(self.mass) not in (1, count):
            raise ValueError(f"--mass: {len(self.mass)} masses for {count} data sets with a load")
        if self.mass and not count:
            raise ValueError("--mass: no data set with a load is named by --loaded")
        if self.com and not self.mass:
            raise ValueError("--com: a centre of mass says nothing without --mass")
        if self.com and len(self.com) not in (3, 3 * count):
            raise ValueError(f"--com: {len(self.com)} numbers are not x y z of {count} loads")


def _require_two_folders(bare: Path | None, loaded: tuple[Path, ...]) -> None:
    if bare is not None and bare.resolve() in {folder.resolve() for folder in loaded}:
        raise ValueError(
            f"--bare and --loaded: both are {bare}: the arm alone has recordings of its own"
        )
