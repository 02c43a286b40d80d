"""Small design problems that several tests share."""

from __future__ import annotations

from functools import cache

import numpy as np

from oed.design.criteria import Criterion
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass, HarmonicClass, SplineClass, TrajectoryClass
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.robot import JointLimits, Robot, imi_scara

HORIZON = 10.0


@cache
def scara() -> tuple[Robot, TorqueModel, BaseParameters]:
    """The paper's arm, its model and its eight base parameters."""
    robot = imi_scara()
    model = TorqueModel.standard(robot)
    return robot, model, base_parameters(model)


def lopsided() -> JointLimits:
    """Asymmetric limits, jerk included."""
    return JointLimits.unlimited(2).with_(
        position=np.array([[-0.4, 1.5], [-2.0, -0.5]]),
        velocity=np.array([[-1.0, 2.0], [-3.0, 0.8]]),
        acceleration=np.array([[-5.0, 4.0], [-2.0, 6.0]]),
        jerk=np.array([[-20.0, 30.0], [-25.0, 25.0]]),
    )


def classes(limits: JointLimits) -> dict[str, TrajectoryClass]:
    """One of every kind of class."""
    return {
        "conservative": HarmonicClass.conservative(limits, HORIZON),
        "harmonic": HarmonicClass.exact(limits, HORIZON),
        "ramped": HarmonicClass.exact(limits, HORIZON, ramp=1.0),
        "fourier": FourierClass(HORIZON, limits),
        "fourier_at_rest": FourierClass(HORIZON, limits, at_rest=True),
        "collocation": SplineClass(HORIZON, limits, segments=13),
        "spline_at_rest": SplineClass(HORIZON, limits, segments=17, degree=5, at_rest=True),
    }


def paper_problem(
    trajectory: TrajectoryClass, criterion: Criterion = "J_d", **given
) -> DesignProblem:
    """The paper's arm and instants with a class of motions."""
    robot, model, base = scara()
    return DesignProblem(
        model, base, trajectory, robot.limits, trajectory.instants(80), criterion, **given
    )
