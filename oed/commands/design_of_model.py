"""`oed design --model model.json`: the motion that narrows what a found model leaves in doubt."""

from __future__ import annotations

from pathlib import Path

from oed.design.default_problem import DefaultProblem, ProblemSettings, default_problem
from oed.design.known_arm import NOISE, KnownTorqueModel
from oed.design.model_prior import completing, for_design, not_designed_for
from oed.errors import NoUsableResult
from oed.estimation.load.same_arm import check_same_robot
from oed.export.model_file import load_model, model_file_at
from oed.robot import Robot


def of_model(
    path: Path, robot: Robot, settings: ProblemSettings
) -> tuple[DefaultProblem, tuple[str, ...]]:
    """The problem of what a model leaves in doubt, and what was assumed.

    Args:
        path: Of the model.json.
        robot: With the limits that the motion keeps.
        settings: What to ask.

    Raises:
        NoUsableResult: If the model has no covariance.
        OtherArm: If it is of another arm.
    """
    found = load_model(model_file_at(path))
    if found.covariance is None:
        raise NoUsableResult(
            f"--model {path}: this model has no covariance; give that of oed identify, diagnose or feasible"
        )
    check_same_robot(found.robot, robot, f"{path} and {robot.name}")
    whole = found.torque_model.with_robot(robot)
    known = for_design(KnownTorqueModel(whole, found.parameters, found.covariance))
    posed = default_problem(known.torque_model, settings)
    names = list(dict.fromkeys(e.name for e in known.torque_model.effects[1:]))
    told = (
        f"excited are {len(posed.problem.base)} base parameters of {path}, with {', '.join(names)}; what "
        f"its covariance tells counts as known, under noise of {NOISE:.1%} of each drive's torque"
    )
    left = {f"{e.name} of {path} is left out: {e.reason}" for e in not_designed_for(whole)}
    problem = completing(posed.problem, known)
    return DefaultProblem(problem, posed.notes, posed.others), (told, *sorted(left))
