"""`oed design --model model.json`: the motion that narrows what a found model leaves in doubt."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from oed.counted import counted
from oed.design.default_problem import DefaultProblem, ProblemSettings, default_problem
from oed.design.known_arm import NOISE, KnownTorqueModel
from oed.design.model_prior import completing, for_design, not_designed_for
from oed.design.problem import DesignProblem
from oed.design.robust_problem import Scenario
from oed.errors import NoUsableResult
from oed.estimation.load.same_arm import check_same_robot
from oed.export.model import Model
from oed.export.model_file import load_model, model_file_at
from oed.export.samples import draw_models
from oed.export.shape_samples import draw_shapes
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
    _, every = _known(path, robot)
    whole, known = every.torque_model, for_design(every)
    posed = default_problem(known.torque_model, settings)
    names = list(dict.fromkeys(e.name for e in known.torque_model.effects[1:]))
    told = (
        f"excited are {len(posed.problem.base)} base parameters of {path}, with {', '.join(names)}; what "
        f"its covariance tells counts as known, under noise of {NOISE:.1%} of each drive's torque"
    )
    left = {f"{e.name} of {path} is left out: {e.reason}" for e in not_designed_for(whole)}
    problem = completing(posed.problem, known)
    return DefaultProblem(problem, posed.notes, posed.others), (told, *sorted(left))


def scenarios_of(
    path: Path, problem: DesignProblem, count: int, seed: int
) -> tuple[tuple[Scenario, ...], tuple[str, ...]]:
    """Models that the data do not tell from the one that a problem was made of, and what was drawn.

    Args:
        path: Of its model.json.
        problem: As `of_model` poses it.
        count: How many.
        seed: Of the draws.

    Raises:
        NoUsableResult: If its bodies are not possible.
    """
    found, known = _known(path, problem.model.robot)
    rng, of_shapes = np.random.default_rng(seed).spawn(2)
    try:
        every = draw_models(found, count, rng)
    except NoUsableResult as error:
        raise NoUsableResult(f"--robust: {path}: {error}") from error
    shapes = found.shapes_of(for_design(known).torque_model)
    drawn = draw_shapes(problem.model, shapes, count, of_shapes)
    own = (for_design(dataclasses.replace(known, parameters=x)) for x in every)
    scenarios = tuple(
        Scenario(model, each.parameters) for model, each in zip(drawn.models, own, strict=True)
    )
    told = f"{counted(count, 'model')} drawn from the covariance of {path}, every body possible" + (
        f", with {', '.join(drawn.names)}" if drawn.names else ""
    )
    left = f"drawn models keep {', '.join(drawn.left)}, which the data leave in doubt"
    return scenarios, (told, *([left] if drawn.left else ()))


def _known(path: Path, robot: Robot) -> tuple[Model, KnownTorqueModel]:
    """A model as it was found, and of the robot that is meant."""
    found = load_model(model_file_at(path))
    if found.covariance is None:
        raise NoUsableResult(
            f"--model {path}: this model has no covariance; give that of oed identify, diagnose or feasible"
        )
    check_same_robot(found.robot, robot, f"{path} and {robot.name}")
    whole = found.torque_model.with_robot(robot)
    return found, KnownTorqueModel(whole, found.parameters, found.covariance)
