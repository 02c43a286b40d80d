"""Samples of a model as JSON, and as ranges for those who randomise their simulation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import with_columns
from oed.export.model import Model
from oed.export.registry import Exported, Target
from oed.export.samples import draw_models, kept_spread
from oed.report.json_file import write_json

FILE, RANGES = "samples.json", "randomisation.json"
TAILS = (2.5, 97.5)  # [%] of the ranges
ENOUGH = 200  # draws, whose spread is known to 5 %
NARROW = 0.9  # of the spread: a band of 95 % then holds 92 %
TERMS = {"friction": "frictionloss", "damping": "damping", "armature": "armature"}  # in MJCF


def write_samples(model: Model, target: Target, count: int, seed: int) -> Exported:
    """Write samples.json and randomisation.json.

    Args:
        model: To draw about.
        target: Where to.
        count: Number of samples.
        seed: Of the draws.
    """
    rng = np.random.default_rng(seed)
    every = draw_models(model, max(count, ENOUGH), rng)
    drawn = every[:count]
    parameters = model.torque_model.parameters
    record = {
        "format": 1,
        "seed": seed,
        "names": [p.name for p in parameters],
        "units": [p.unit for p in parameters],
        "estimate": model.parameters,
        "samples": drawn,
    }
    write_json(target.folder / FILE, record)
    write_json(target.folder / RANGES, {"format": 1, "tails": TAILS, **ranges(model, drawn)})
    use = f"each row of samples in {FILE} is a model; ranges by body and joint are in {RANGES}"
    return Exported((FILE, RANGES), use, notes=_narrowed(model, every, rng))


def _narrowed(
    model: Model, drawn: Float[ndarray, "count p"], rng: np.random.Generator
) -> tuple[str, ...]:
    """What is said where the samples know more than the estimate."""
    kept = kept_spread(model, drawn, rng)
    if kept > NARROW:
        return ()
    told = (
        f"torques of the samples spread {kept:.0%} of what the covariance says, as much of that is cut "
        "off where no body can be: a band of these torques is too narrow; a motion that excites more "
        "leaves less to cut"
    )
    return (told,)


def ranges(model: Model, drawn: Float[ndarray, "count p"]) -> dict[str, Any]:
    """Ranges of what simulators randomise, by the names that MJCF has: body masses and joints."""
    robot = model.robot
    bodies: dict[str, dict[str, Any]] = {
        joint.link: {"mass": _range(drawn[:, 10 * i])} for i, joint in enumerate(robot.joints)
    }
    for i, joint in enumerate(robot.joints):
        centres = drawn[:, 10 * i + 1 : 10 * i + 4] / drawn[:, 10 * i : 10 * i + 1]
        bodies[joint.link]["ipos"] = [_range(centres[:, k]) for k in range(3)]
    joints: dict[str, dict[str, list[float]]] = {name: {} for name in robot.joint_names}
    effects: dict[str, list[float]] = {}
    for effect, place in with_columns(model.torque_model.effects[1:]):
        start = 10 * robot.n + place.start
        if effect.joint_term is not None:
            (parameter,) = effect.parameters
            name = robot.joint_names[parameter.joint or 0]
            joints[name][TERMS[effect.joint_term]] = _range(drawn[:, start])
        else:
            effects |= _named(effect.parameters, drawn[:, start : start + len(effect.parameters)])
    return {"body": bodies, "joint": joints, "effect": effects}


def _named(parameters: Sequence, drawn: Float[ndarray, "count k"]) -> dict[str, list[float]]:
    return {p.name: _range(column) for p, column in zip(parameters, drawn.T, strict=True)}


def _range(values: Float[ndarray, " count"]) -> list[float]:
    # One more draw lies between two neighbours with probability 1 / (count + 1): Weibull's positions.
    return [float(x) for x in np.percentile(values, TAILS, method="weibull")]
