"""What is concluded from a log: joints, units, repetitions."""

import tomllib

import numpy as np
import pytest

from oed.errors import DataSetError
from oed.experiment.importing.assign_joints import RobotJoints
from oed.experiment.importing.joint_names import match_joints
from oed.experiment.importing.manifest_text import manifest_text
from oed.experiment.importing.propose_columns import propose_columns
from oed.experiment.importing.propose_units import propose_units
from oed.experiment.importing.repetition import find_period
from oed.experiment.logs import Log, table_of
from oed.experiment.units import plain
from oed.robot.builtin import imi_scara
from tests.experiment.importing.wave import wave
from tests.experiment.tiny_dataset import csv_text
from tests.running import oed

UR = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint")


@pytest.mark.parametrize(
    ("labels", "joints", "found"),
    [
        (["b", "a"], ["a", "b"], {"a": "a", "b": "b"}),
        (["Elbow Joint", "SHOULDER_PAN_JOINT", "shoulder-lift-joint"], UR, {
            "shoulder_pan_joint": "SHOULDER_PAN_JOINT",
            "shoulder_lift_joint": "shoulder-lift-joint",
            "elbow_joint": "Elbow Joint",
        }),
        (["elbow.pos", "shoulder_lift.pos", "shoulder_pan.pos"], UR, {
            "shoulder_pan_joint": "shoulder_pan.pos",
            "shoulder_lift_joint": "shoulder_lift.pos",
            "elbow_joint": "elbow.pos",
        }),
        (
            ["fer_joint1", "fer_joint2", "fer_joint3", "fer_finger_joint1"],
            ["panda_joint1", "panda_joint2", "panda_joint3", "panda_finger_joint1", "panda_finger_joint2"],
            {"panda_joint1": "fer_joint1", "panda_joint2": "fer_joint2", "panda_joint3": "fer_joint3"},
        ),
        (["wing", "tail"], ["shoulder", "elbow"], {}),
        (["joint_1", "joint_2"], ["joint_2", "joint_3"], {"joint_2": "joint_2"}),
    ],
)  # fmt: skip
def test_names_of_joints(labels, joints, found):
    assert match_joints(labels, joints) == found


def proposal(*columns: str, joints=("shoulder", "elbow"), **stated):
    table = table_of({name: np.arange(5.0) for name in columns}, "log.csv")
    return propose_columns(Log("log.csv", (table,)), RobotJoints(joints, joints), stated)


@pytest.mark.parametrize("unit", ["1/min", "min^-1", "U/min", "rpm"])
def test_velocities_in_turns_a_minute_are_taken_however_written(unit):
    names = [f"{what} {j}" for what in ("pos", "speed", "torque") for j in ("shoulder", "elbow")]
    found = proposal("t", *(f"{n} [{unit}]" if "speed" in n else n for n in names))
    assert found.columns["dq"] == (f"speed shoulder [{unit}]", f"speed elbow [{unit}]")
    assert plain(found.units["dq"][0]) == "rpm"


def test_a_velocity_in_words_is_no_position_of_another_kind():
    """Left out, a logged velocity would be differentiated without a word."""
    log = "theta[0],theta[1],theta_dot[0],theta_dot[1],torques[0],torques[1],timestamps"
    assert proposal(*log.split(",")).columns["dq"] == ("theta_dot[0]", "theta_dot[1]")


@pytest.mark.parametrize(
    ("columns", "q", "tau", "t"),
    [
        ("time,success_rate,state.q[0],state.q[1],state.q_d[0],state.q_d[1],state.tau_J[0],state.tau_J[1]",
         ("state.q[0]", "state.q[1]"), ("state.tau_J[0]", "state.tau_J[1]"), ("time",)),
        ("theta[0],theta[1],theta_dot[0],theta_dot[1],torques[0],torques[1],timestamps",
         ("theta[0]", "theta[1]"), ("torques[0]", "torques[1]"), ("timestamps",)),
        ("Zeit [s],Winkel shoulder,Winkel elbow,Drehmoment shoulder,Drehmoment elbow",
         ("Winkel shoulder", "Winkel elbow"), ("Drehmoment shoulder", "Drehmoment elbow"), ("Zeit [s]",)),
        ("Zeitstempel,Winkel shoulder,Winkel elbow,Drehmoment shoulder,Drehmoment elbow",
         ("Winkel shoulder", "Winkel elbow"), ("Drehmoment shoulder", "Drehmoment elbow"), ("Zeitstempel",)),
        ("T,time,q_1,q_2,tau_1,tau_2", ("q_1", "q_2"), ("tau_1", "tau_2"), ("time",)),
        ("T,q_1,q_2,tau_1,tau_2", ("q_1", "q_2"), ("tau_1", "tau_2"), ("T",)),
        ("temps,q_1,q_2,tau_1,tau_2", ("q_1", "q_2"), ("tau_1", "tau_2"), ("temps",)),
        ("Temps [s],q_1,q_2,tau_1,tau_2", ("q_1", "q_2"), ("tau_1", "tau_2"), ("Temps [s]",)),
        ("temps,sec,q_1,q_2,tau_1,tau_2", ("q_1", "q_2"), ("tau_1", "tau_2"), ("sec",)),
        ("temps_1,temps_2,t,q_1,q_2,tau_1,tau_2", ("q_1", "q_2"), ("tau_1", "tau_2"), ("t",)),
        ("t,q_elbow,q_shoulder,dq_elbow,dq_shoulder,tau_elbow,tau_shoulder",
         ("q_shoulder", "q_elbow"), ("tau_shoulder", "tau_elbow"), ("t",)),
        ("record_time,time,mp1,mp2,ip1,ip2,mt1,mt2",
         ("mp1", "mp2"), ("mt1", "mt2"), ("time",)),
        ("timestamp,q1_deg,q2_deg,torque 1 (Nm),torque 2 (Nm)",
         ("q1_deg", "q2_deg"), ("torque 1 (Nm)", "torque 2 (Nm)"), ("timestamp",)),
    ],
)  # fmt: skip
def test_columns_as_loggers_name_them(columns, q, tau, t):
    found = proposal(*columns.split(","))
    assert found.columns["q"] == q
    assert found.columns["tau"] == tau
    assert found.columns["t"] == t


def test_positions_of_a_gripper_beside_the_arm_may_be_left_out():
    names = ("t", *(f"{key}_{j}" for key in ("q", "tau") for j in (1, 2, 3)))
    table = table_of({name: np.arange(5.0) for name in names}, "log.csv")
    joints = RobotJoints(("shoulder", "elbow", "left", "right"), ("shoulder", "elbow"))
    log = Log("log.csv", (table,))
    with pytest.raises(DataSetError, match=r"say which they are with --joints.*, or .* --columns"):
        propose_columns(log, joints, {})
    found = propose_columns(log, joints, {"q": ("q_1", "q_2")})
    assert found.joints == joints.arm
    assert found.columns["tau"] == ("tau_1", "tau_2")


def test_units_in_names_are_taken():
    found = proposal("timestamp [ms]", "q1_deg", "q2_deg", "torque 1 (mNm)", "torque 2 (mNm)")
    assert found.units == {"t": ("ms",), "q": ("deg",), "tau": ("mN m",)}


def test_a_measured_torque_goes_before_a_current_and_a_current_before_a_command():
    both = ("t", "q_1", "q_2", "actual_current_1", "actual_current_2")
    assert proposal(*both, "target_moment_1", "target_moment_2").torque == "current"
    assert proposal(*both, "tau_1", "tau_2").torque == "measured"
    assert proposal("t", "q_1", "q_2", "target_moment_1", "target_moment_2").torque == "commanded"


@pytest.mark.parametrize(
    ("columns", "why"),
    [
        ("t,q_1,q_2", "no torque"),
        ("t,q_1,q_2,effort_1", "no torque"),
        ("t,a,b,c", "no joint positions"),
        ("t,q_1,q_2,q_3,tau_1,tau_2,tau_3", "positions of 3 joints"),
        ("t,q_a,q_b,tau_a,tau_b", "say which they are with --joints"),
        ("1,2,3,4,5", "have no names"),
    ],
)
def test_what_cannot_be_concluded_is_asked_for(columns, why):
    with pytest.raises(DataSetError, match=why):
        proposal(*columns.split(","))


@pytest.mark.parametrize(
    ("t_scale", "q_scale", "dq_scale", "tau_scale", "units"),
    [
        (1, 1, 1, 1, {}),
        (1e3, 180 / np.pi, 180 / np.pi, 1, {"t": "ms", "q": "deg", "dq": "deg/s"}),
        (1e9, 1, 60 / (2 * np.pi), 1e3, {"t": "ns", "dq": "rpm", "tau": "mN m"}),
        (1e6, 180 / np.pi, 1, 1, {"t": "us", "q": "deg"}),
    ],
)
def test_units_by_ranges(t_scale, q_scale, dq_scale, tau_scale, units):
    t = np.arange(0, 10, 0.01)
    robot = imi_scara()
    dq = np.column_stack([2 * np.cos(2 * t), -2.1 * np.sin(3 * t)])
    limit = np.abs(robot.limits.torque).max(axis=1)
    limit = np.where(np.isfinite(limit), limit, 50.0)
    robot = robot.with_limits(
        robot.limits.with_(
            torque=np.column_stack([-limit, limit]), position=np.tile([-2.0, 2.0], (2, 1))
        )
    )
    values = {"t": t_scale * t[:, None], "q": wave(t, q_scale), "dq": dq_scale * dq}
    values["tau"] = wave(t, tau_scale) * 0.3 * limit
    found = propose_units(values, robot, {}).units
    assert {key: value[0] for key, value in found.items()} == units


def test_ticks_of_servos():
    t = np.arange(0, 10, 0.01)
    robot = imi_scara()
    ticks = np.round(wave(t) / (2 * np.pi) * 4096 + 2048)
    found = propose_units({"t": t[:, None], "q": ticks, "tau": wave(t)}, robot, {})
    assert found.units["q"] == ("ticks",)
    assert found.ticks_per_turn == 4096
    assert found.zero is not None
    assert found.zero.tolist() == [2048, 2048]


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_period_is_found_to_a_part_of_a_sample(noise):
    t = np.arange(0, 43.0, 0.01)
    rng = np.random.default_rng(0)
    angle = 2 * np.pi * t[:, None] / 7.3131
    q = np.hstack(
        [np.sin(angle) + 0.3 * np.sin(3 * angle), np.cos(2 * angle) + 0.2 * np.sin(5 * angle)]
    )
    found = find_period(t, q + noise * rng.standard_normal(q.shape))
    assert found == pytest.approx(7.3131, rel=2e-4)


def test_a_motion_that_does_not_repeat_has_no_period():
    t = np.arange(0, 40, 0.01)
    q = np.column_stack(
        [np.sin(0.7 * t) + np.sin(np.sqrt(2) * t), np.cos(np.pi * t / 3 + 0.01 * t**2)]
    )
    assert find_period(t, q) is None


def test_recordings_of_short_names_stand_under_their_own_headers():
    entries = [{"file": f"{role}.csv", "role": role} for role in ("estimation", "test")]
    content = {"format": 1, "units": {"tau": "N m"}, "recording": entries}
    assert tomllib.loads(manifest_text(content, ())) == content


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (("--columns", "speed=q_1"), "--columns speed=: nothing is called so"),
        (("--units", "speed=deg"), "--units speed=: nothing is called so"),
        (("--joints", "joint_9", "joint_1"), "--joints: the robot has no joint 'joint_9'"),
        (("--joints", "joint_1"), "positions of 2 joints (q_1, q_2)"),
        (("--sign", "1"), "oed import: --sign: has 1 values for 2 joints"),
        (("--current-to-torque", "9"), "oed import: --current-to-torque: has 1 values"),
        (("--columns", "q=q_1,q_2", "tau=q_1,q_2"), "oed import: --columns tau=: names 'q_1'"),
        (("--rate", "0"), "--rate 0 is no number from 1"),
    ],
)
def test_what_is_stated_and_cannot_be_is_refused_as_it_was_stated(tmp_path, capsys, options, line):
    """Not passed over, and not as a key of a file that was never written."""
    (tmp_path / "a.csv").write_text(csv_text(0), encoding="utf-8")
    given = ("import", tmp_path / "a.csv", "--robot", "builtin:imi_scara", "--out", tmp_path / "o")
    assert oed(*given, *options) == 2
    assert line in capsys.readouterr().err
    assert not (tmp_path / "o").exists()
