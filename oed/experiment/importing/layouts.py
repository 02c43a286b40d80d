"""How loggers name what they log, by quantity, the likelier name first.

Sources: sensor_msgs/JointState and control_msgs (ROS 2), the field list of Universal Robots' RTDE,
`franka::logToCSV` of libfranka, LeRobot's feature names, pyfri for the KUKA LBR, MuJoCo's arrays.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from oed.experiment.drive import TorqueKind
from oed.experiment.units import Quantity
from oed.experiment.units_in_names import marked_unit, suffixed_unit

TIMES = (
    *("t", "time", "stamp", "timestamp", "header.stamp", "time_stamp", "t_s", "seconds", "sec"),
    *("elapsed", "elapsed_time", "duration", "zeit", "clock", "received"),
    *("times", "timestamps"),
)
POSITIONS = (
    *("q", "actual_q", "state.q", "position", "positions", "pos", "feedback.positions"),
    *("actual.positions", "observation.state", "joint_position", "joint_positions", "joint_pos"),
    *("q_meas", "q_measured", "q_actual", "measured_position", "measured_joint_position", "qpos"),
    *("angle", "angles", "joint_angle", "joint_angles", "theta", "axis", "mp"),
    *("winkel",),
)
VELOCITIES = (
    *("dq", "qd", "actual_qd", "state.dq", "velocity", "velocities", "vel", "feedback.velocities"),
    *("actual.velocities", "observation.velocity", "joint_velocity", "joint_velocities"),
    *("joint_vel", "dq_meas", "dq_measured", "measured_velocity", "qvel", "speed", "omega"),
    *("qdot", "q_dot", "theta_dot", "geschwindigkeit", "drehzahl"),
)
ACCELERATIONS = ("ddq", "qdd", "acceleration", "accelerations", "acc", "joint_acceleration")
TORQUES: Mapping[TorqueKind, Sequence[str]] = {
    "measured": (
        *("tau", "tau_j", "state.tau_j", "effort", "efforts", "torque", "torques", "joint_torque"),
        *("joint_torques", "measured_torque", "measured_joint_torque", "tau_meas", "tau_measured"),
        *("observation.effort", "observation.torque", "joint_effort", "moment", "mt"),
        *("feedback.effort", "actual.effort", "drehmoment"),
    ),
    "current": (
        *("actual_current_as_torque", "actual_current", "current", "currents", "motor_current"),
        *("motor_currents", "joint_current", "observation.current", "i", "iq", "i_q"),
    ),
    "commanded": (
        *("tau_cmd", "tau_d", "tau_j_d", "cmd.tau_j", "cmd.tau_j_d", "commanded_torque"),
        *("target_moment", "qfrc_actuator", "ctrl"),
    ),
}
TEMPERATURES = ("temperature", "temperatures", "temp", "joint_temperatures", "motor_temperature")
EPISODES = ("episode_index", "episode", "run")
# Words for what was asked for, not measured.
NOT_MEASURED = {
    *("cmd", "command", "commanded", "target", "desired", "des", "reference", "ref", "setpoint"),
    *("goal", "error", "action"),
}
# Columns of lists whose elements may be of several quantities, and then say so.
MIXED = ("observation.state", "state")


@dataclass(frozen=True)
class Named:
    """A column's name taken apart.

    Attributes:
        column: The name in the log.
        stem: What is logged, in lower case.
        label: Of which joint, "" if it is of none.
        unit: Stated in the name; "" if none is.
    """

    column: str
    stem: str
    label: str
    unit: str


def columns_of(
    columns: Mapping[str, str], stems: Sequence[str], quantity: Quantity
) -> list[list[Named]]:
    """Columns of a quantity, those of one stem together, in the order of the stems.

    Args:
        columns: What each column is called, by its name.
        stems: Names of the quantity.
        quantity: Whose units a name may state.
    """
    found = []
    for stem in stems:
        named = [
            one
            for column, called in columns.items()
            if (one := _take_apart(column, called, stem, quantity)) is not None
        ]
        if named:
            found.append(named)
    return found


def _take_apart(column: str, called: str, stem: str, quantity: Quantity) -> Named | None:
    for name, unit in _with_units(called, quantity):
        label = _label(name, stem)
        if label is not None:
            return Named(column, stem, label, unit)
    return None


def _with_units(called: str, quantity: Quantity) -> list[tuple[str, str]]:
    """The name without the unit that it may end with, and with no unit."""
    ways = (suffixed_unit(called, quantity), marked_unit(called, quantity))
    return [*((name, unit) for name, unit in ways if unit), (called, "")]


def _label(called: str, stem: str) -> str | None:
    """Whose a column with this stem is: the rest of its name; None if it has another stem.

    A folder before the name, as of HDF5 groups and structs, changes nothing unless it says that
    something was asked for and not measured.
    """
    name = called.strip()
    label = _label_of(name, stem)
    folder, _, inner = name.replace("/", ".").partition(".")
    if label is not None or not inner or NOT_MEASURED & set(re.split(r"[_ ]", folder.lower())):
        return label
    return _label(inner, stem)


def _label_of(name: str, stem: str) -> str | None:
    lower = name.lower()
    bracket = re.fullmatch(r"(.*?)\[(.+)\]", name)
    if bracket is not None:
        return _label_of_element(bracket[1].lower(), bracket[2], stem)
    if lower == stem:
        return ""
    if lower.startswith(stem):
        rest = name[len(stem) :]
        if rest.isdigit():
            return rest
        if rest[0] in "._/ (" and rest.strip("._/ ()"):
            return rest.strip("._/ ()")
    if lower.endswith(stem) and name[: -len(stem)][-1] in "._/ ":
        return name[: -len(stem)].strip("._/ ")
    return None


def _label_of_element(owner: str, element: str, stem: str) -> str | None:
    """Whose an element of a column of lists is, such as "elbow.pos" of LeRobot's state."""
    said = re.fullmatch(r"(.+)[._](pos|position|vel|velocity|effort|torque|current)", element)
    label = element if said is None else said[1]
    if owner in MIXED and said is not None and said[2] not in ("pos", "position"):
        return label if said[2] == stem else None
    return label if owner == stem else None
