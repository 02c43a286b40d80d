"""What the machine is: kinematics, inertial parameters, gravity, limits."""

from oed.robot.builtin import BUILTIN_ROBOTS, imi_scara
from oed.robot.inertia import (
    PARAMETER_SYMBOLS,
    PARAMETER_UNITS,
    parameters_from_pseudo_inertia,
    pseudo_inertia,
    transform_parameters,
)
from oed.robot.joint_sum import JointSum, read_sum
from oed.robot.limits import JointLimits
from oed.robot.load import arm_joints, described, load_arm, load_robot
from oed.robot.robot import Joint, Robot

__all__ = [
    "BUILTIN_ROBOTS",
    "PARAMETER_SYMBOLS",
    "PARAMETER_UNITS",
    "Joint",
    "JointLimits",
    "JointSum",
    "Robot",
    "arm_joints",
    "described",
    "imi_scara",
    "load_arm",
    "load_robot",
    "parameters_from_pseudo_inertia",
    "pseudo_inertia",
    "read_sum",
    "transform_parameters",
]
