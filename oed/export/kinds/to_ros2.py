"""A model as parameters of a ROS 2 node, with the C code that a controller calls."""

from __future__ import annotations

from typing import Any

import numpy as np
import yaml

from oed.dynamics.effects import with_columns
from oed.export.c_code import write_c
from oed.export.calibrated_robot import CalibratedRobot
from oed.export.model import Model
from oed.export.predictor import Predictor
from oed.export.registry import Exported, Target
from oed.report.json_file import write_atomically
from oed.robot.inertia import PARAMETER_SYMBOLS

FILE = "model_parameters.yaml"


def write(model: Model, target: Target) -> Exported:
    """Write model_parameters.yaml, oed_model.c and oed_model.h."""
    predictor = Predictor.of(model, target.step)
    source, header = write_c(predictor, target.folder)
    # Whatever the node is called: the wildcard stands for every one.
    document = {"/**": {"ros__parameters": {"dynamics": _parameters(model, target.step)}}}
    text = yaml.safe_dump(document, sort_keys=False, allow_unicode=True, width=100)
    write_atomically(target.folder / FILE, text)
    use = f"--params-file {FILE}; a controller calls oed_model_torque of {source.name}"
    return Exported((FILE, source.name, header.name), use, predictor.left_out)


def _parameters(model: Model, step: float) -> dict[str, Any]:
    """Nested names and lists of one type, as ROS 2 has them."""
    robot = model.robot
    held = CalibratedRobot.of(model.torque_model, model.parameters)
    joints = {
        joint.name: {
            "inertial": held.robot.parameters[10 * i : 10 * i + 10].tolist(),
            "coulomb": float(held.coulomb[i]),
            "viscous": float(held.viscous[i]),
            "rotor_inertia": float(held.rotor_inertia[i]),
            "effort": [float(x) for x in _finite(robot.limits.torque[i])],
        }
        for i, joint in enumerate(robot.joints)
    }
    return {
        "robot": robot.name,
        "step": step,
        "gravity": robot.gravity.tolist(),
        "joint_names": list(robot.joint_names),
        "inertial_names": list(PARAMETER_SYMBOLS),
        "joints": joints,
        "effects": _effects(model),
    }


def _effects(model: Model) -> dict[str, Any]:
    found = {}
    for k, (effect, place) in enumerate(with_columns(model.torque_model.effects)):
        if k == 0 or effect.joint_term is not None:
            continue
        found[f"effect_{k}"] = {
            "name": effect.name,
            "parameter_names": [p.name for p in effect.parameters],
            "units": [p.unit for p in effect.parameters],
            "values": model.parameters[place].tolist(),
        }
    return found


def _finite(bounds: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(bounds), bounds, 0.0)
