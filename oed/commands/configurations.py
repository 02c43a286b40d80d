"""What every command can be told: frozen configurations, and nothing that takes time to load.

`oed --help` and shell completion read these classes alone. The names of models and effects stand
here as text; a test holds that they are those of the library.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Annotated, Literal

import tyro

from oed.commands.options import Count, OutFolder, Seed

ModelName = Literal["standard", "offset", "rotor"]
Prior = Literal["auto", "file", "neutral"]
MOST_POINTS = 1_000_000  # that a motion is written with
# Distance that links keep, and the largest that can be asked for [m]; as `oed.design.collision`.
CLEARANCE = 0.01
MOST_CLEARANCE = 0.15


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
            (offset), or with rotor inertias besides (rotor); if not given, rotor where the data set
            declares gears and determines it, else standard.
        sign_width: Velocity over which Coulomb friction turns [rad/s]; from the data if not given.
        smoke: Do less, to see that it works.
    """

    data: Annotated[Path, tyro.conf.Positional]
    out: OutFolder
    joints: tuple[str, ...] = ()
    cutoff: float | None = None
    model: ModelName | None = None
    sign_width: float | None = None
    smoke: bool = False


@dataclass(frozen=True, kw_only=True)
class Check(DataSetCommand):
    """Look a data set over before any fit: units, signs, ranges, noise, what it cannot determine.

    Each finding is green, amber or red; a cause is named only if it alone repairs the fit. Leaves
    check.json and report.html, and says which design completes the data. The exit status is 3 if
    something has to be mended first.
    """


@dataclass(frozen=True, kw_only=True)
class Identify(DataSetCommand):
    """Estimate the dynamic parameters of an arm, with intervals, and validate them.

    Leaves model.json, estimate.json, parameters.csv and report.html.

    Attributes:
        model: Torque model: standard, offset or rotor; or a model.json, whose effects it has. As drives
            and data have it if not given.
        robust: Use Huber's loss in place of least squares.
    """

    model: ModelName | Path | None = None  # pyright: ignore[reportIncompatibleVariableOverride]
    robust: bool = False


@dataclass(frozen=True, kw_only=True)
class Feasible(DataSetCommand):
    """Estimate parameters that belong to real bodies, and write URDF, SDF and MJCF with them.

    Leaves model.json, estimate.json, parameters.yaml, calibrated_robot.urdf, .sdf, .xml and report.html. Each
    robot file is loaded again and its torques are compared.

    Attributes:
        model: Torque model: standard, offset or rotor; or a model.json, whose effects it has. As drives
            and data have it if not given.
        prior: What is pulled to: the inertials of the robot's file (file), bodies of the size of
            the links (neutral), or the former where they are no placeholders (auto).
        kind: Of that pull.
        weight: Of that pull; by cross-validation if not given.
        total_mass: Of all moving links [kg], where it is known.
        collision: Each link's mass lies within its collision geometry.
        seed: Of poses and bootstrap.
    """

    model: ModelName | Path | None = None  # pyright: ignore[reportIncompatibleVariableOverride]
    prior: Prior = "auto"
    kind: Literal["entropic", "quadratic"] = "entropic"
    weight: float | None = None
    total_mass: float | None = None
    collision: bool = False
    seed: Seed = 0


@dataclass(frozen=True, kw_only=True)
class Diagnose(Command):
    """Find out what the torque model lacks, add it, and show the error before and after.

    Every term is added, dropped and named by one criterion; test recordings report, and have no
    say. Leaves diagnosis.json, report.html, model.json, figures and, where two causes cannot be
    told apart, the motion that tells them apart.

    Attributes:
        data: Folder of the data set.
        out: Folder for the results.
        model: Base model; as of oed identify if not given. Or a model.json: a second round, which looks
            for what that lacks.
        max_effects: Most effects to add; three a joint if not given, at least six.
        candidates: Effects that may be named; the whole catalogue if not given.
        smoke: Do less, to see that it works.
        seed: Of everything random.
        budget: CPU time after which nothing more is looked for [s].
    """

    data: Annotated[Path, tyro.conf.Positional]
    out: OutFolder
    model: ModelName | Path | None = None
    max_effects: int | None = None
    candidates: tuple[str, ...] = ()
    smoke: bool = False
    seed: Seed = 0
    budget: float | None = None

    def __post_init__(self) -> None:
        if self.max_effects is not None and self.max_effects < 0:
            raise ValueError(
                f"--max-effects {self.max_effects} must not be negative; 0 only tests the model"
            )
        if self.budget is not None and not self.budget >= 0:
            raise ValueError(f"--budget {self.budget:g} must not be negative: seconds of CPU time")


@dataclass(frozen=True, kw_only=True)
class Payload(Command):
    """Weigh what an arm carries: mass, centre of mass and inertia, with intervals.

    The arm is known from recordings without the load (--bare), from a model that was identified
    before (--model), or else from the robot's file, which is wide. Leaves payload.json, the load as
    URDF, SDF, MJCF, ROS 2 message and URScript, and report.html.

    Attributes:
        loaded: Data set with the load.
        bare: Data set of the same arm without it.
        model: model.json of the arm without it.
        out: Folder for the results.
        frame: Link or frame of the robot's file about which the load is told; the flange, or the
            last link, if not given.
        joints: Names of the joints to use; all if not given.
        cutoff: Cut-off of the low-pass [Hz]; chosen from the data if not given.
        torque_model: Of the arm: as --model of oed identify.
        smoke: Do less, to see that it works.
    """

    loaded: Path
    bare: Path | None = None
    model: Path | None = None
    out: OutFolder
    frame: str = ""
    joints: tuple[str, ...] = ()
    cutoff: float | None = None
    torque_model: ModelName | None = None
    smoke: bool = False


@dataclass(frozen=True, kw_only=True)
class Gains(Command):
    """Find every joint's N m per A, gear included, from recordings with known loads.

    Leaves gains.json, report.html and, where every gain is told, drive.toml with the lines for
    dataset.toml. Without a mass only ratios of gains are told. The exit status is 3 if nothing is.

    Attributes:
        loaded: Data sets with a load each.
        bare: Data set of the same arm without a load.
        mass: Of the load in each data set, or of the one that is in all [kg].
        com: Its centre of mass in the frame, x y z for each or for the one [m]; estimated if not
            given.
        out: Folder for the results.
        frame: Link or frame of the robot's file that holds the load; the flange, or the last link,
            if not given.
        joints: Names of the joints to use; all if not given.
        cutoff: Cut-off of the low-pass [Hz]; chosen from the data if not given.
        torque_model: Of the arm: as --model of oed identify.
        smoke: Do less, to see that it works.
    """

    loaded: tuple[Path, ...] = ()
    bare: Path | None = None
    mass: tuple[float, ...] = ()
    com: tuple[float, ...] = ()
    out: OutFolder
    frame: str = ""
    joints: tuple[str, ...] = ()
    cutoff: float | None = None
    torque_model: ModelName | None = None
    smoke: bool = False

    def __post_init__(self) -> None:
        count = len(self.loaded)
        if self.bare is None and count < 2:
            raise ValueError(
                "--bare: name a recording of the bare arm, or two with different loads"
            )
        if self.mass and len(self.mass) not in (1, count):
            raise ValueError(f"--mass: {len(self.mass)} masses for {count} data sets with a load")
        if self.mass and not count:
            raise ValueError("--mass: no data set with a load is named by --loaded")
        if not all(mass > 0 and isfinite(mass) for mass in self.mass):
            raise ValueError("--mass: a mass is not a positive number of kg")
        if self.com and not self.mass:
            raise ValueError("--com: a centre of mass says nothing without --mass")
        if self.com and len(self.com) not in (3, 3 * count):
            raise ValueError(f"--com: {len(self.com)} numbers are not x y z of {count} loads")
        if not all(map(isfinite, self.com)):
            raise ValueError("--com: a number is not finite")


@dataclass(frozen=True, kw_only=True)
class Design(Command):
    """Find the motion that excites an arm best, and prove that it keeps its limits.

    By default it is clear of itself, from rest to rest, and uses 90 % of the velocity and
    acceleration limits. Leaves motion.csv, ROS 2 JointTrajectory files, design.json,
    report.html and motion.html, in which the arm moves. Where a limit is not kept, nothing for a controller is
    written and the exit status is 3.

    Attributes:
        robot: URDF, SDF, MJCF, xacro or DH file, or builtin:NAME.
        data: Folder of a data set whose robot is meant; recordings need not be there yet.
        out: Folder for the results.
        joints: Names of the joints to move; the arm proper if not given.
        model: Torque model whose parameters the motion is to excite.
        horizon: Length of the motion [s].
        criterion: What is optimised: log10 det of the information (J_d), its condition number
            (J_k), its mean (A) or worst (E) variance.
        scaled_columns: Scale the columns first, for J_k, A and E: J_k_scaled and so on.
        periodic: The motion may start and end at speed, as the paper's do.
        margin: Share of velocity and acceleration limits that is used.
        scale: Speed of the finished motion, as a share.
        gravity: In the base frame [m/s^2], for an arm on a wall or ceiling.
        sum: Bounds on sums of positions, as coupled drives have: joint_2+0.5*joint_3:-2.8:2.8
            [rad or m].
        no_torque: Ignore effort limits.
        prior: design.json of earlier experiments, which this one completes.
        clearance: Distance that links keep from one another [m].
        no_clearance: Links may touch; whether they do is told.
        avoid_collision: Refuse a motion that cannot be proven clear.
        package: Where a ROS package lies, as NAME=DIR, should its meshes not be found.
        box: Lower and upper x, y, z that no body's origin may leave [m].
        rate: Set points a second [Hz].
        evaluations: Of the criterion; the same number and seed give the same motion.
        budget: CPU time after which the optimiser stops in any case [s].
        trajectory: Class of motions, by name: fourier (a series), collocation (piecewise-linear
            acceleration), spline (of degree 5), harmonic (sines of free frequencies, as the
            paper's), or one that was registered from outside.
        optimiser: By name: interior_point, slsqp, hopping, evolution (CMA-ES), genetic (the paper's),
            random_search, or one that was registered from outside.
        payload: Excite what the arm holds, the arm being known; --horizon 3 to 10 is enough.
        arm: model.json of the arm, whose errors then count; the arm is taken for known if not given.
        frame: Link or frame of the robot's file that holds the load; the flange, or the last link,
            if not given.
        static: With --payload: postures to stand in, and no motion.
        poses: How many of these.
        smoke: Do less, to see that it works.
        seed: Of starts and of the states of the bound.
    """

    robot: str = ""
    data: str = ""
    out: OutFolder
    joints: tuple[str, ...] = ()
    model: ModelName = "standard"
    horizon: float = 10.0
    criterion: Literal["J_k", "J_d", "A", "E"] = "J_d"
    scaled_columns: bool = False
    periodic: bool = False
    margin: float = 0.9
    scale: float = 1.0
    gravity: tuple[float, float, float] | None = None
    sum: tuple[str, ...] = ()
    no_torque: bool = False
    prior: tuple[str, ...] = ()
    clearance: float = CLEARANCE
    no_clearance: bool = False
    avoid_collision: bool = False
    package: tuple[str, ...] = ()
    box: tuple[float, float, float, float, float, float] | None = None
    rate: float = 100.0
    evaluations: Count = 1000
    budget: float = 60.0
    trajectory: str = "fourier"
    optimiser: str = "interior_point"
    payload: bool = False
    arm: str = ""
    frame: str = ""
    static: bool = False
    poses: Count = 8
    smoke: bool = False
    seed: Seed = 0

    def __post_init__(self) -> None:
        if bool(self.robot) == bool(self.data):
            raise ValueError("name either a robot's file (--robot) or a data set (--data)")
        self._check_numbers()
        for option in ("arm", "frame", "static"):
            if getattr(self, option) and not self.payload:
                raise ValueError(f"--{option}: only with --payload")
        if self.avoid_collision and self.no_clearance:
            raise ValueError("--avoid-collision and --no-clearance contradict each other")
        if self.gravity is not None and self.data:
            raise ValueError("--gravity: with --data, dataset.toml says it")
        if self.gravity is not None and not all(map(isfinite, self.gravity)):
            raise ValueError("--gravity: a component is not a finite number")
        if self.box is not None and not all(map(isfinite, self.box)):
            raise ValueError("--box: a bound is not a finite number")
        if self.box is not None and any(
            a >= b for a, b in zip(self.box[::2], self.box[1::2], strict=True)
        ):
            raise ValueError("--box: each lower bound must be below its upper bound")

    def _check_numbers(self) -> None:
        for name in ("rate", "budget", "horizon"):
            value = getattr(self, name)
            if not (value > 0 and isfinite(value)):
                raise ValueError(f"--{name} {value:g} is not a positive number")
        if self.rate * self.horizon > MOST_POINTS:
            raise ValueError(
                f"--rate {self.rate:g} for --horizon {self.horizon:g} is more than "
                f"{MOST_POINTS} set points"
            )
        for name in ("margin", "scale"):
            share = getattr(self, name)
            if not 0.0 < share <= 1.0:
                raise ValueError(f"--{name} {share:g} is not a share above 0 and up to 1")
        if not 0.0 <= self.clearance < MOST_CLEARANCE:
            raise ValueError(
                f"--clearance {self.clearance:g} is not between 0 and {MOST_CLEARANCE:g} m"
            )

    @property
    def inputs(self) -> tuple[str, ...]:
        """What is read."""
        return tuple(given for given in (self.robot, self.data, *self.prior, self.arm) if given)


@dataclass(frozen=True, kw_only=True)
class Calibrate(Command):
    """From recordings to a model that runs: identify, diagnose, estimate bodies, export.

    What the model lacks is found before bodies are estimated, so that it does not end up in masses.
    Leaves a folder for each step and index.html, which links their pages.

    Attributes:
        data: Folder of the data set.
        out: Folder for everything.
        model: Base model of all steps: standard, offset or rotor; as of oed identify if not given.
        to: Forms that the model is exported to, as of oed export.
        rate: At which a controller or a simulation asks for torque [Hz].
        prior: As of oed feasible.
        max_effects: As of oed diagnose.
        candidates: As of oed diagnose.
        smoke: Do less, to see that it works.
        seed: Of everything random.
    """

    data: Annotated[Path, tyro.conf.Positional]
    out: OutFolder
    model: ModelName | None = None
    to: tuple[str, ...] = ("c", "mujoco")
    rate: float = 1000.0
    prior: Prior = "auto"
    max_effects: int | None = None
    candidates: tuple[str, ...] = ()
    smoke: bool = False
    seed: Seed = 0


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
        rate: At which a controller or a simulation asks for torque [Hz].
        samples: Number of models to draw that the data do not tell from this one, for those who
            randomise their simulation: samples.json and randomisation.json.
        seed: Of these draws.
    """

    model: Annotated[Path, tyro.conf.Positional]
    to: tuple[str, ...] = ()
    out: OutFolder
    rate: float = 1000.0
    samples: int = 0
    seed: Seed = 0

    def __post_init__(self) -> None:
        if self.samples < 0:
            raise ValueError(f"--samples {self.samples} must not be negative")
        if not self.to and not self.samples:
            raise ValueError("--to: name at least one form, such as mujoco")
        if not (self.rate > 0 and isfinite(self.rate)):
            raise ValueError(f"--rate {self.rate:g} is not a positive number")


@dataclass(frozen=True, kw_only=True)
class ImportLog(Command):
    """Make a data set of log files: ROS 2 bags, CSV, Parquet, .mat, .npz, HDF5.

    Finds columns, joints, units and roles, says why, and writes a folder with a dataset.toml that
    can be read, corrected and kept. Nothing is written if anything cannot be used.

    Attributes:
        logs: Log files of one format, in the order in which they were recorded.
        robot: The robot's file, or builtin:NAME.
        out: Folder to make.
        joints: The robot's joints in the order of the log's columns.
        columns: Columns, as in t=time q=a,b tau=c,d; dq= leaves velocities out.
        units: Units, as in q=deg tau=mNm t=ms.
        sign: 1 or -1 a joint, where the log counts the other way.
        zero: What is logged where each joint of the robot is at zero.
        ticks_per_turn: Of encoders that are logged in ticks.
        rate: Rows a second, where no column tells the time [Hz].
        fixed: Where joints stood that are not logged [rad or m], as in finger=0.04.
        torque: How the torque was obtained.
        current_to_torque: Joint torque per motor current, gear included, one a joint [N m/A].
        gravity: In the robot's base frame [m/s^2].
        roles: One a log.
        reference: Leave logs where they are instead of copying them.
    """

    logs: Annotated[tuple[Path, ...], tyro.conf.Positional]
    robot: str
    out: OutFolder
    joints: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    sign: tuple[float, ...] = ()
    zero: tuple[float, ...] = ()
    ticks_per_turn: float | None = None
    rate: float | None = None
    fixed: tuple[str, ...] = ()
    torque: Literal["measured", "current", "commanded"] | None = None
    current_to_torque: tuple[float, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    roles: tuple[Literal["estimation", "validation", "test"], ...] = ()
    reference: bool = False

    def __post_init__(self) -> None:
        if not self.logs:
            raise ValueError("name at least one log file")


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
    out: OutFolder | None = None
    states: int = 1000
    seed: Seed = 0

    def __post_init__(self) -> None:
        if not self.robots:
            raise ValueError("name at least one robot file")


@dataclass(frozen=True, kw_only=True)
class Demo(Command):
    """Go the whole way once on a simulated arm: design, record, check, identify, diagnose, export.

    The arm is the paper's two-link SCARA, with a cable that its model does not declare. Leaves a
    folder for each step, and index.html, which links their pages.

    Attributes:
        out: Folder for everything.
        hidden: What the arm has and its model lacks.
        smoke: Do less, to see that it works.
        seed: Of motions, noise and everything random.
    """

    out: OutFolder = Path("oed-demo")
    hidden: Literal["cable", "stribeck", "none"] = "cable"
    smoke: bool = False
    seed: Seed = 0
