"""`oed design --payload`: a motion, or postures, that tell what an arm holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.commands.configurations import Design
from oed.counted import counted
from oed.design.bound.least_deviation import DeviationSearch, least_deviation
from oed.design.collision import Surroundings
from oed.design.default_limits import with_default_limits
from oed.design.default_problem import ProblemSettings, default_problem
from oed.design.known_arm import NOISE, KnownTorqueModel
from oed.design.load_problem import GENERAL, LoadProblem, load_problem
from oed.design.model_prior import for_design
from oed.design.problem import DesignProblem
from oed.design.static_poses import static_poses
from oed.design.still_joints import hold_still_joints
from oed.dynamics.models import build_model
from oed.errors import NoUsableResult, OedError
from oed.estimation.load.same_arm import check_same_robot
from oed.export.model_file import load_model, model_file_at
from oed.report.page import Page, Section, Table, Text, Verdict, write_page
from oed.report.provenance import Provenance
from oed.report.study_files import DESIGN
from oed.report.table import Row, text_table, write_csv
from oed.robot import Robot
from oed.robot.attached_frame import AttachedFrame, find_frame

ROOM = "torque limits count the arm alone: leave room for the load by --margin or --scale"
RECORD = (
    "start the log a second before the motion and end it a second after: what filters need to settle is "
    "then cut from the standstill, not from the motion"
)
NORMAL = 1.96  # deviations of half an interval of 95 %
QUICK = DeviationSearch(first=300, rounds=2, steps=20, drawn=300, kept=50, climbs=20)
STATIC = (
    "Hold each posture for two seconds or more, come to it slowly, from both sides where friction is "
    "large, and record positions and torques all the way: weight tells mass and centre of mass, and "
    "nothing of the inertia."
)


def of_load(arm: DesignProblem, config: Design) -> tuple[LoadProblem, tuple[str, ...]]:
    """The problem of the load that an arm holds, and what was assumed.

    Raises:
        RobotError: If there is no such frame.
        OtherArm: If the model is of another arm.
    """
    robot = arm.model.robot
    frame, known = _frame_and_model(robot, config)
    problem = load_problem(arm, frame.joint, known)
    errors = (
        f"the arm is known as well as {Path(config.arm).name} says"
        if known
        else f"the arm is taken for one that {GENERAL:g} s of general motion have told (--arm "
        "model.json: its own covariance counts)"
    )
    excited = (
        f"excited are the ten parameters of a load at {frame.name}, beside friction of any shape, which "
        "each day has its own, and which grows with the load; the criterion is the sum of their "
        f"variances, in units of 10 g, 5 g m and 10 g m^2; {errors}"
    )
    return problem, (excited, ROOM, RECORD)


def worth_of_load(
    problem: LoadProblem, z: Float[ndarray, " size"], rng: np.random.Generator, *, is_quick: bool
) -> str:
    """To how much a motion is expected to tell the mass, and to how much any could.

    Args:
        problem: Of the load.
        z: The motion.
        rng: Of the states that the bound looks at.
        is_quick: Whether to look at few.
    """
    masses = [k for k, name in enumerate(problem.base.names) if name.startswith("load_m_")]
    if not masses:
        return "the mass is told by no motion: no joint of this arm feels it by itself"
    (mass,) = masses
    variance = np.linalg.inv(problem.information(z, scaled=False))[mass, mass]
    bound = least_deviation(problem, mass, rng, QUICK if is_quick else None)
    told, least = (NORMAL * x for x in (float(np.sqrt(variance)), bound.lower))
    return (
        f"expected: the mass to {told:.2g} kg (half of a 95 % interval), where currents leave {NOISE:.1%} "
        "of what the drives are made for unexplained; no motion as long within these limits could tell it "
        f"to better than {least:.2g} kg (searched for, not proven)"
    )


def _frame_and_model(robot: Robot, config: Design) -> tuple[AttachedFrame, KnownTorqueModel | None]:
    frame = find_frame(robot, config.frame)
    if not config.arm:
        return frame, None
    known = load_model(model_file_at(Path(config.arm)))
    if known.covariance is None:
        raise NoUsableResult(
            f"--arm {config.arm}: this model has no covariance; give that of oed identify"
        )
    check_same_robot(known.robot, robot, f"{Path(config.arm).name} and {robot.name}")
    found = KnownTorqueModel(known.torque_model, known.parameters, known.covariance)
    return frame, for_design(found)


def run_static(config: Design, robot: Robot) -> int:
    """Leave postures as poses.csv and report.html."""
    robot, held = hold_still_joints(robot)
    robot, assumed = with_default_limits(robot)
    with DESIGN.in_folder(config.out, config.inputs) as results:
        settings = ProblemSettings(torque=False)
        arm = default_problem(build_model(str(config.model), robot), settings).problem
        problem, told = of_load(arm, config)
        frame, _ = _frame_and_model(robot, config)
        checked = _clearance(robot, config)
        rng = np.random.default_rng(config.seed)
        q = static_poses(problem, frame.joint, config.poses, rng, is_clear=checked.holds)
        rows, told = _rows(robot, q), (told[0], *filter(None, [checked.note]))
        with results.replaced() as new:
            write_csv(new / "poses.csv", rows)
            provenance = Provenance.collect(config, seed=config.seed)
            write_page(
                new / "report.html",
                _page(robot, rows, checked, (*robot.notes, *held, *assumed, *told), provenance),
            )
            provenance.write(new / "provenance.json")
    print(text_table(rows))
    print(f"{counted(len(rows), 'posture')}, {checked.words}")
    if checked.note:
        print(f"note: {checked.note}")
    print(STATIC)
    print(f"open {config.out / 'report.html'}")
    return 0


@dataclass(frozen=True)
class _Checked:
    """What is looked at of a posture.

    Attributes:
        holds: Whether it may be taken.
        words: What is known of those that are.
        note: What is not; empty where nothing is left to say.
    """

    holds: Callable[[Float[ndarray, " joints"]], bool]
    words: str
    note: str


def _clearance(robot: Robot, config: Design) -> _Checked:
    """Whether a posture is clear, as far as shapes are known and may not touch.

    Raises:
        RobotError: If a box is to be kept, and the robot has no file.
    """
    walls = None if config.box is None else np.array(config.box).reshape(-1, 2)
    within = "each within its limits" if walls is None else "each within its limits and the box"
    try:
        around = Surroundings(robot, walls, config.clearance, walls_only=config.no_clearance)
    except OedError as error:
        if walls is not None:
            raise
        return _Checked(lambda _: True, within, f"not checked: clear of itself: {error}")
    words = f"{within}, and clear of itself" if around.is_judged else within
    note = "not checked: clear of itself: --no-clearance" if config.no_clearance else around.note
    return _Checked(around.is_clear, words, note)


def _rows(robot: Robot, q: Float[ndarray, "poses joints"]) -> list[Row]:
    units = ["rad" if joint.kind == "revolute" else "m" for joint in robot.joints]
    names = [f"{name} [{unit}]" for name, unit in zip(robot.joint_names, units, strict=True)]
    return [
        {"pose": k, **{n: float(x) for n, x in zip(names, posture, strict=True)}}
        for k, posture in enumerate(q, start=1)
    ]


def _page(
    robot: Robot,
    rows: list[Row],
    checked: _Checked,
    notes: tuple[str, ...],
    provenance: Provenance,
) -> Page:
    return Page(
        title=f"Postures that tell what {robot.name} holds",
        verdict=Verdict(
            "warning" if checked.note else "good",
            f"{counted(len(rows), 'posture')}, {checked.words}.",
            f"{f'{checked.note[0].upper()}{checked.note[1:]}. ' if checked.note else ''}{STATIC}",
        ),
        sections=(
            Section("The postures", (Table(rows),)),
            Section("What is assumed", tuple(Text(f"{note}.") for note in notes)),
            Section("How it was made", (Text(f"Commit {provenance.commit}, {provenance.date}."),)),
        ),
    )
