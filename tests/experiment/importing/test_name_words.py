"""Columns are told by the words in their names: who says it, of what, of which joint."""

import numpy as np
import pytest

from oed.errors import DataSetError
from oed.experiment.importing.assign_joints import RobotJoints
from oed.experiment.importing.propose_columns import propose_columns
from oed.experiment.logs import Log, table_of

JOINTS = ("shoulder", "elbow")


def proposal(columns: str, **stated: tuple[str, ...]):
    names = columns.split(",")
    table = table_of({name: np.arange(5.0) for name in names}, "log.csv")
    return propose_columns(Log("log.csv", (table,)), RobotJoints(JOINTS, JOINTS), stated)


@pytest.mark.parametrize(
    ("q", "tau"),
    [
        ("actual_joint_position_{}", "measured_joint_torque_{}"),
        ("actual_q_{}", "actual_current_{}"),
        ("msr_joint_pos[{}]", "msr_joint_tau[{}]"),
        ("joint_states.position[{}]", "joint_states.effort[{}]"),
        ("/joint_states/position[{}]", "/joint_states/effort[{}]"),
        ("q_meas_{}", "tau_meas_{}"),
        ("q_measured[{}]", "tau_J[{}]"),
        ("measured_joint_positions_{}", "joint_torques_measured_{}"),
        ("joint_{}_actual_position", "joint_{}_actual_torque"),
        ("actual_position_joint{}", "actual_torque_joint{}"),
        ("J{}_ActPos", "J{}_ActTorque"),
        ("actualJointPosition{}", "actualJointTorque{}"),
        ("Position (actual) {} [deg]", "Torque (actual) {} [Nm]"),
        ("current_joint_position_{}", "joint_current_{}"),
        ("present_position_{}", "present_current_{}"),
        ("feedback.positions[{}]", "feedback.effort[{}]"),
        ("observation.state[{}]", "observation.effort[{}]"),
        ("axis_{}_pos", "axis_{}_motor_current"),
        ("actuator_{}_position", "actuator_{}_current_motor"),
        ("actuators[{}].position", "actuators[{}].torque"),
        ("Winkel_{}", "Motorstrom_{}"),
        ("J{} Angle [deg]", "J{} Motor current [A]"),
        ("Joint angle {}", "Motor current {}"),
        ("robot/state/position[{}]", "robot/effort[{}]"),
        ("q_{}", "motor_torque_{}"),
        ("link_position_{}", "motor_current_{}"),
        ("q_{}", "joint_{}_motor_torque"),
        ("q_{}", "tau_joint_{}"),
        ("q_{}", "torque_filtered_{}"),
        ("data_set/q_{}", "data_set/tau_{}"),
        ("training_set.q_{}", "training_set.tau_{}"),
        ("Pos{}", "Trq{}"),
        ("J{} pos (deg)", "J{} cur (mA)"),
        ("ur5_actual_q_{}", "ur5_actual_current_{}"),
        ("left arm position {}", "left arm torque {}"),
    ],
)
@pytest.mark.parametrize("first", [0, 1])
def test_a_quantity_of_joints_is_told_whatever_stands_around_it(q, tau, first):
    positions, torques = (tuple(name.format(first + j) for j in range(2)) for name in (q, tau))
    found = proposal(",".join(["t", *positions, *torques]))
    assert found.joints == JOINTS
    assert found.columns["q"] == positions
    assert found.columns["tau"] == torques


@pytest.mark.parametrize("first", ["measured", "commanded"])
@pytest.mark.parametrize(
    ("measured", "commanded"),
    [
        ("actual_{}_{}", "target_{}_{}"),
        ("{}_meas_{}", "{}_cmd_{}"),
        ("msr_joint_{}[{}]", "cmd_joint_{}[{}]"),
        ("feedback.{}[{}]", "desired.{}[{}]"),
        ("{}_{}", "{}_ref_{}"),
        ("robot/{}_{}", "setpoints/{}_{}"),
        ("actual_{}_{}", "{}_{}"),
        ("feedBack.{}[{}]", "planned.{}[{}]"),
        ("{}_actual_{}", "{}_demand_{}"),
        ("actual_{}_{}", "set_{}_{}"),
    ],
)
def test_what_was_measured_goes_before_what_was_commanded(measured, commanded, first):
    order = (measured, commanded) if first == "measured" else (commanded, measured)
    columns = ["t"]
    for kind in ("position", "velocity", "torque"):
        columns += [name.format(kind, j) for name in order for j in range(2)]
    found = proposal(",".join(columns))
    for key, kind in (("q", "position"), ("dq", "velocity"), ("tau", "torque")):
        assert found.columns[key] == tuple(measured.format(kind, j) for j in range(2))
        (note,) = (note for note in found.notes if note.startswith(f"taken: {key} "))
        taken, passed = note.split(", not from ")
        assert measured.format(kind, 1) in taken
        assert commanded.format(kind, 1) in passed
    assert found.torque == "measured"


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize(
    ("quantity", "likelier", "other"),
    [
        ("q", "link_position_{}", "motor_position_{}"),
        ("q", "link/position_{}", "motor/position_{}"),
        ("q", "position_{}", "motor_q_{}"),
        ("q", "link_position_{}", "actual_motor_position_{}"),
        ("q", "joint_{}_position", "joint_{}_motor_position"),
        ("q", "q_link_{}", "q_motor_{}"),
        ("q", "q_{}", "q_raw_{}"),
        ("q", "raw/q_{}", "filtered/q_{}"),
        ("tau", "torque_raw_{}", "torque_filtered_{}"),
        ("tau", "tau_{}", "tau_smoothed_{}"),
        ("tau", "joint_torque_{}", "motor_torque_{}"),
    ],
)
def test_of_two_that_were_measured_the_likelier_is_taken_and_a_note_says_so(
    quantity, likelier, other, order
):
    names = {"q": "theta_{}", "tau": "drehmoment_{}"}
    pairs = [[name.format(j) for j in (1, 2)] for name in (likelier, other)][::order]
    rest = [name.format(j) for key, name in names.items() if key != quantity for j in (1, 2)]
    found = proposal(",".join(["t", *pairs[0], *pairs[1], *rest]))
    assert found.columns[quantity] == tuple(likelier.format(j) for j in (1, 2))
    (note,) = (note for note in found.notes if note.startswith(f"taken: {quantity} "))
    assert likelier.format(1) in note.split(", not from ")[0]
    assert other.format(1) in note.split(", not from ")[1]


def test_a_set_beside_a_quantity_is_what_was_commanded():
    with pytest.raises(DataSetError, match=r"commanded \(pos_set.J1 … pos_set.J2\) and none"):
        proposal("t,pos_set.J1,pos_set.J2,tau_1,tau_2")
    found = proposal("t,set/q_1,set/q_2,q_1,q_2,tau_1,tau_2")
    assert found.columns["q"] == ("q_1", "q_2")


def test_of_one_kind_nothing_is_said_to_be_taken_before_another():
    found = proposal("t,actual_q_0,actual_q_1,tau_0,tau_1")
    assert not any(note.startswith("taken") for note in found.notes)


def test_commanded_torques_are_taken_as_such_where_none_were_measured():
    found = proposal("t,q_0,q_1,target_torque_0,target_torque_1,error.torque_0,error.torque_1")
    assert found.columns["tau"] == ("target_torque_0", "target_torque_1")
    assert found.torque == "commanded"


def test_positions_that_were_commanded_are_not_taken_for_measured_ones():
    with pytest.raises(DataSetError, match=r"commanded \(target_q_0 … target_q_1\) and none"):
        proposal("t,target_q_0,target_q_1,tau_0,tau_1")


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize(
    ("joints", "other"),
    [
        ("/joint_states/effort[{}]", "/external_torques/effort[{}]"),
        ("tau_{}", "external.tau_{}"),
        ("tau_{}", "feedforward/tau_{}"),
        ("torque[{}]", "ft_sensor/torque[{}]"),
    ],
)
def test_torque_of_something_else_in_a_folder_is_not_that_of_the_joints(joints, other, order):
    folder = "/joint_states/" if "/joint_states" in joints else ""
    names = [f"{folder}position[{j}]" for j in range(2)]
    mine, others = ([name.format(j) for j in range(2)] for name in (joints, other))
    found = proposal(",".join(["t", *names, *(mine + others)[::order]]))
    assert found.columns["tau"] == tuple(mine)
    with pytest.raises(DataSetError, match=r"no torque found where the positions .*--columns tau="):
        proposal(",".join(["t", *names, *others]))


@pytest.mark.parametrize(("arm", "another"), [("left", "right"), ("robot1", "robot2"), ("0", "1")])
def test_torques_of_one_arm_are_not_taken_for_those_of_another(arm, another):
    q, tau, others = (
        [f"{a}/{k}_{j}" for j in (1, 2)] for a, k in ((arm, "q"), (arm, "tau"), (another, "tau"))
    )
    assert proposal(",".join(["t", *q, *tau, *others])).columns["tau"] == tuple(tau)
    with pytest.raises(DataSetError, match="no torque found where the positions"):
        proposal(",".join(["t", *q, *others]))


@pytest.mark.parametrize(
    "columns",
    [
        "t,left/q_1,left/q_2,right/q_1,right/q_2,left/tau_1,left/tau_2",
        "t,left/q_1,right/q_1,left/tau_1,right/tau_1",
        "t,left/q.elbow,left/q.shoulder,right/q.elbow,right/q.shoulder,tau.elbow,tau.shoulder",
        "t,J1_q,joint_1_q,J1_tau,joint_1_tau",
        "t,left_arm_1_q,left_arm_2_q,right_arm_1_q,right_arm_2_q,left_arm_1_tau,left_arm_2_tau",
        "t,left_q_1,left_q_2,right_q_1,right_q_2,left_tau_1,left_tau_2,right_tau_1,right_tau_2",
    ],
)
def test_of_two_arms_the_columns_must_be_named(columns):
    with pytest.raises(DataSetError, match=r"which .*are of the robot, as in --columns q="):
        proposal(columns)


@pytest.mark.parametrize(
    ("tool", "force"), [("tcp_position_{}", "gravity_torque_{}"), ("tool q {}", "ext tau {}")]
)
def test_words_before_a_quantity_tell_that_it_is_of_something_else(tool, force):
    others = [name.format(j) for name in (tool, force) for j in (1, 2)]
    found = proposal(",".join(["t", *others, "q_1", "q_2", "tau_1", "tau_2"]))
    assert found.columns["q"] == ("q_1", "q_2")
    assert found.columns["tau"] == ("tau_1", "tau_2")
    with pytest.raises(DataSetError, match="no torque found where the positions"):
        proposal(",".join(["t", *others, "q_1", "q_2"]))


def test_a_column_of_lists_may_be_named_by_its_name():
    arms = [f"{arm}.{k}[{j}]" for arm in ("left", "right") for k in ("q", "tau") for j in (0, 1)]
    found = proposal(",".join(["t", *arms]), q=("right.q",))
    assert found.columns["q"] == ("right.q[0]", "right.q[1]")
    assert found.columns["tau"] == ("right.tau[0]", "right.tau[1]")


def test_columns_that_differ_by_a_number_are_listed_together():
    with pytest.raises(DataSetError, match=r"Columns: t, q_1 … q_2, load_1 … load_2$"):
        proposal("t,q_1,q_2,load_1,load_2")


def test_positions_that_were_named_may_stand_in_a_folder_of_their_own():
    names = ("t", "leader/q_1", "leader/q_2", "tau_1", "tau_2")
    table = table_of({name: np.arange(5.0) for name in names}, "log.csv")
    stated = {"q": ("leader/q_1", "leader/q_2")}
    found = propose_columns(Log("log.csv", (table,)), RobotJoints(JOINTS, JOINTS), stated)
    assert found.columns["tau"] == ("tau_1", "tau_2")


@pytest.mark.parametrize(
    ("columns", "q", "tau"),
    [
        ("t,q_1,q_2,q_3,tau_1,tau_2,tau_3", ("q_3", "q_1"), ("tau_3", "tau_1")),
        ("t,q_u,q_v,tau_u,tau_v", ("q_v", "q_u"), ("tau_v", "tau_u")),
        ("t,b,a,tau_1,tau_2", ("b", "a"), ("tau_1", "tau_2")),
    ],
)
def test_torques_are_of_the_joints_of_positions_that_were_named(columns, q, tau):
    found = proposal(columns, q=q)
    assert found.columns["q"] == q
    assert found.columns["tau"] == tau
    assert found.joints == JOINTS


@pytest.mark.parametrize("word", ["error", "cmd", "desired"])
def test_a_velocity_that_was_not_measured_is_left_out(word):
    columns = f"t,q_0,q_1,dq_{word}_0,dq_{word}_1,tau_0,tau_1"
    assert "dq" not in proposal(columns).columns


def test_a_measured_quantity_of_something_else_is_passed_over():
    columns = "t,measured_angle_x,measured_angle_y,measured_angle_z,q_0,q_1,tau_0,tau_1"
    assert proposal(columns).columns["q"] == ("q_0", "q_1")


def test_numbers_of_joints_are_those_of_the_robot_where_its_names_have_them():
    names = [f"{quantity}_joint_{j}" for quantity in ("q", "tau") for j in (2, 3)]
    table = table_of({name: np.arange(5.0) for name in ("t", *names)}, "a")
    joints = ("joint_3", "joint_2")
    found = propose_columns(Log("a", (table,)), RobotJoints(joints, joints), {})
    assert found.columns["q"] == ("q_joint_3", "q_joint_2")
    assert found.joints == joints
