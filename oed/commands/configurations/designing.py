"""The command that finds a motion: oed design."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from oed.commands.configurations.command import Command, ModelName, check_model
from oed.commands.options import Count, Gravity, OutFolder, Positive, Range, Rate, Real, Seed, Share

# That a motion is written with: the messages for ROS 2 then take 120 MB, and half a minute.
MOST_POINTS = 200_000
# An arm stands in each for some seconds, and they are picked from ten times as many.
MOST_POSES = 1e2
MOST_SCENARIOS = 1e3  # each is evaluated at every step of the search
LEAST_POINTS = 50  # ten a period of the fifth harmonic, the highest of most classes
# Distance that links keep, and the largest that can be asked for [m]; as `oed.design.collision`.
CLEARANCE = 0.01
MOST_CLEARANCE = 0.15


@dataclass(frozen=True, kw_only=True)
class Design(Command):
    """Find the motion that excites an arm best, and prove that it keeps its limits.

    By default the arm keeps clear of itself, starts and ends at rest, and uses 90 % of the velocity
    and acceleration limits. Leaves motion.csv, ROS 2 JointTrajectory files, design.json, and
    report.html, in which the arm moves. Where a limit is not kept, nothing for a controller is
    written and the exit status is 3.

    Attributes:
        robot: URDF, SDF, MJCF, xacro or DH file, or builtin:NAME.
        data: Folder of a data set whose robot is meant; recordings need not be there yet.
        out: Folder for the results.
        joints: Names of the joints to move; the arm proper if not given.
        model: Torque model whose parameters the motion is to excite: standard, offset or rotor; or a
            model.json, of which it excites what is uncertain, and whose robot is taken where neither
            --robot nor --data is given.
        horizon: Length of the motion [s].
        criterion: What is optimised: log10 det of the information (J_d), its condition number
            (J_k), its mean (A) or worst (E) variance.
        scaled_columns: Scale the columns first, for J_k, A and E: J_k_scaled and so on.
        periodic: The motion may start and end at speed, as the paper's do.
        margin: Share of velocity and acceleration limits that is used.
        scale: Speed of the finished motion, as a share.
        gravity: In the base frame [m/s^2], for an arm on a wall or ceiling.
        sum: Bounds on sums of positions, as coupled drives have, such as
            joint_2+0.5*joint_3:-2.8:2.8 [rad or m].
        no_torque: Ignore effort limits.
        prior: design.json of earlier experiments, which this one completes.
        clearance: Distance that links keep from one another [m].
        no_clearance: Let links touch; the status says whether they do.
        avoid_collision: Refuse a motion that cannot be proven clear.
        package: Folder of a ROS package, as NAME=DIR, where its meshes are not found.
        box: Least and largest x, then y, then z, that no body's origin may leave [m].
        rate: Set points a second [Hz].
        evaluations: Evaluations of the criterion; the same number and seed give the same motion.
        budget: CPU time after which the optimiser stops in any case [s].
        trajectory: Class of motions, by name: fourier (a series), collocation (piecewise-linear
            acceleration), spline (of degree 5), harmonic (sines of free frequencies, as the
            paper's), or one that was registered from outside.
        optimiser: By name: interior_point, slsqp, hopping, evolution (CMA-ES), genetic (the paper's),
            random_search, or one that was registered from outside.
        robust: Also count models drawn from the covariance of --model FILE: torque limits hold under
            each, and the criterion is its mean (expected) or its worst over them. A motion for the
            nominal model is found too, to compare with.
        scenarios: With --robust: number of models that are drawn.
        payload: Excite what the arm holds, the arm being known; --horizon 3 to 10 is enough.
        arm: With --payload: model.json of the arm, whose errors then count; if not given, those that
            30 s of general motion leave.
        frame: Link or frame of the robot's file that holds the load; the flange, or the last link,
            if not given.
        static: With --payload: postures to stand in, and no motion.
        poses: With --static: number of postures.
        smoke: Do less, to see that it works.
        seed: Seed of the starts and of the states of the bound.
    """

    robot: str = ""
    data: str = ""
    out: OutFolder
    joints: tuple[str, ...] = ()
    model: ModelName | Path = "standard"
    horizon: Positive = 10.0
    criterion: Literal["J_k", "J_d", "A", "E"] = "J_d"
    scaled_columns: bool = False
    periodic: bool = False
    margin: Share = 0.9
    scale: Share = 1.0
    gravity: tuple[Gravity, Gravity, Gravity] | None = None
    sum: tuple[str, ...] = ()
    no_torque: bool = False
    prior: tuple[str, ...] = ()
    clearance: float = CLEARANCE
    no_clearance: bool = False
    avoid_collision: bool = False
    package: tuple[str, ...] = ()
    box: tuple[Real, Real, Real, Real, Real, Real] | None = None
    rate: Rate = 100.0
    evaluations: Count = 1000
    budget: Positive = 60.0
    trajectory: str = "fourier"
    optimiser: str = "interior_point"
    robust: Literal["no", "expected", "worst"] = "no"
    scenarios: Annotated[int, Range(2.0, MOST_SCENARIOS)] = 20
    payload: bool = False
    arm: str = ""
    frame: str = ""
    static: bool = False
    poses: Annotated[int, Range(1.0, MOST_POSES)] = 8
    smoke: bool = False
    seed: Seed = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_arm()
        self._check_numbers()
        for option in ("arm", "frame", "static"):
            if getattr(self, option) and not self.payload:
                raise ValueError(f"--{option}: only with --payload")
        if self.avoid_collision and self.no_clearance:
            raise ValueError("--avoid-collision and --no-clearance contradict each other")
        if self.box is not None and any(
            a >= b for a, b in zip(self.box[::2], self.box[1::2], strict=True)
        ):
            raise ValueError("--box: each lower bound must be below its upper bound")

    def _check_arm(self) -> None:
        """Refuse what leaves open which arm is meant, or says it twice."""
        check_model(self.model)
        is_file = isinstance(self.model, Path)
        if (self.robot and self.data) or not (self.robot or self.data or is_file):
            raise ValueError("name either a robot's file (--robot) or a data set (--data)")
        if self.gravity is not None and self.data:
            raise ValueError("--gravity: with --data, dataset.toml says it")
        if is_file and self.gravity is not None:
            raise ValueError("--gravity: with --model FILE, the file says it")
        if is_file and self.joints and not (self.robot or self.data):
            raise ValueError("--joints: with --model FILE, the motion is one of the file's joints")
        if self.robust != "no" and self.payload:
            raise ValueError(
                "--robust: with --payload the criterion counts the arm's errors already (--arm)"
            )
        if self.robust != "no" and not is_file:
            raise ValueError("--robust: give what is in doubt, as --model model.json")
        if is_file and self.payload:
            raise ValueError("--model: with --payload, a file is given as --arm")

    def _check_numbers(self) -> None:
        if self.rate * self.horizon / self.scale < LEAST_POINTS:
            raise ValueError(
                f"--rate {self.rate:g} for --horizon {self.horizon:g} is fewer than {LEAST_POINTS} set "
                "points, which a controller would join by another motion"
            )
        if self.rate * self.horizon / self.scale > MOST_POINTS:
            slowed = f" at --scale {self.scale:g}" if self.scale < 1.0 else ""
            raise ValueError(
                f"--rate {self.rate:g} for --horizon {self.horizon:g}{slowed} is more than "
                f"{MOST_POINTS} set points"
            )
        if not 0.0 <= self.clearance < MOST_CLEARANCE:
            raise ValueError(
                f"--clearance {self.clearance:g} is not between 0 and {MOST_CLEARANCE:g} m"
            )

    @property
    def inputs(self) -> tuple[str, ...]:
        """What is read."""
        file = str(self.model) if isinstance(self.model, Path) else ""
        return tuple(x for x in (self.robot, self.data, *self.prior, self.arm, file) if x)
