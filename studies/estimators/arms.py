"""The arms of the contest: a planar SCARA, a SCARA with a quill, a UR5, a Panda."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.robot import Robot
from studies.bench.robots import ROBOTS
from studies.carrying_arms import ARMS

SEED = 20140801
# By which each link's parameters and each friction are off in what a laboratory believes beforehand.
BELIEF_SPREAD = 0.10
KEYS = ("planar", "quill", "ur5", "panda")


@dataclass(frozen=True)
class ContestArm:
    """An arm, its model and what is true.

    Attributes:
        model: Rigid body, Coulomb and viscous friction.
        base: Its base parameters.
        truth: (b,) of them.
        file: The robot as its file has it, off by as much.
        believed: (b,) what is known beforehand: feedforward and iterative estimators start there.
        coulomb: (n,) [N m or N].
        noise: (n,) deviation of the torque's noise [N m or N].
        highest: Frequency up to which motions have harmonics [Hz].
    """

    model: TorqueModel
    base: BaseParameters
    truth: Float[ndarray, " base"]
    file: Robot
    believed: Float[ndarray, " base"]
    coulomb: Float[ndarray, " joints"]
    noise: Float[ndarray, " joints"]
    highest: float

    @property
    def robot(self) -> Robot:
        """As it is."""
        return self.model.robot


@cache
def arm_of(key: str) -> ContestArm:
    """The same for all cases."""
    kind = ROBOTS["scara"] if key == "planar" else ARMS["scara" if key == "quill" else key]
    if key == "planar":
        with tempfile.TemporaryDirectory() as folder:
            robot = ROBOTS["scara"].declared(Path(folder))
    else:
        robot = ARMS["scara" if key == "quill" else key].robot
    model = TorqueModel.standard(robot)
    base = base_parameters(model)
    friction = np.ravel(np.transpose([kind.coulomb, kind.viscous]))
    rng = np.random.default_rng(SEED)
    links = 1 + BELIEF_SPREAD * np.repeat(rng.standard_normal(robot.n), 10)
    joints = 1 + BELIEF_SPREAD * rng.standard_normal(len(friction))
    return ContestArm(
        model,
        base,
        base.from_standard(np.concatenate([robot.parameters, friction])),
        robot.with_parameters(robot.parameters * links),
        base.from_standard(np.concatenate([robot.parameters * links, friction * joints])),
        np.array(kind.coulomb),
        np.array(kind.noise),
        kind.highest,
    )
