"""What an import passed over is said in one line."""

from pathlib import Path

import pytest
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

from oed.experiment.importing.import_log import ImportChoices, propose_import
from oed.robot import load_robot
from tests.experiment.importing.laboratory_logs import (
    JOINTS,
    LOGS,
    Truth,
    rtde_frame,
    simulate,
)


@pytest.fixture(scope="module")
def truth(arm) -> Truth:
    return simulate(load_robot(arm), rows=300)


def unused(log, arm) -> list[str]:
    notes = propose_import([log], ImportChoices(str(arm), name="set"), "set").notes
    return [note for note in notes if note.startswith("unused")]


@pytest.mark.parametrize(
    ("kind", "line"),
    [
        (
            "RTDE CSV, commas",
            "unused: 6 columns or topics: target_q_0 … target_q_2, target_moment_0 … target_moment_2",
        ),
        ("LeRobot Parquet", "unused: 4 columns or topics: action[0] … action[2], task"),
        (
            "HDF5",
            "unused: 3 columns or topics: command.joint_positions[0] … command.joint_positions[2]",
        ),
        (
            "rosbag2 SQLite",
            "unused: 2 columns or topics: /joint_states.position.finger, /joint_states.velocity.finger",
        ),
        ("NumPy", None),
        ("ros2 topic echo --csv", None),
    ],
)
def test_columns_of_one_name_are_told_together(kind, line, arm, truth, tmp_path):
    assert unused(LOGS[kind](truth, tmp_path), arm) == ([] if line is None else [line])


def test_columns_that_are_named_by_joint_are_told_together(arm, truth, tmp_path):
    frame = rtde_frame(truth).rename(
        columns=lambda name: name if name == "timestamp" else f"{name[:-1]}{JOINTS[int(name[-1])]}"
    )
    frame.to_csv(tmp_path / "a.csv", index=False)
    (line,) = unused(tmp_path / "a.csv", arm)
    assert "target_q_shoulder … target_q_wrist, target_moment_shoulder … target" in line


def test_of_many_the_first_are_named_and_all_are_counted(arm, truth, tmp_path):
    frame = rtde_frame(truth).assign(**{f"{letter}_state": 1.0 for letter in "abcdefghij"})
    frame.to_csv(tmp_path / "a.csv", index=False)
    (line,) = unused(tmp_path / "a.csv", arm)
    assert line.startswith("unused: 16 columns or topics: target_q_0 … target_q_2, ")
    assert line.endswith("e_state, f_state, … (12 such groups in all)")


def test_another_arm_and_other_messages_are_told_by_topic(arm, truth, tmp_path):
    (line,) = unused(bag_of_two_arms(truth, tmp_path / "bag"), arm)
    assert line == (
        "unused: 2 columns or topics: topic /right/joint_states, topic /force (geometry_msgs/msg/Vector3)"
    )


def bag_of_two_arms(truth: Truth, path: Path) -> Path:
    store = get_typestore(Stores.ROS2_HUMBLE)
    vector, state = (
        store.types[name] for name in ("geometry_msgs/msg/Vector3", "sensor_msgs/msg/JointState")
    )
    time, header = (
        store.types[name] for name in ("builtin_interfaces/msg/Time", "std_msgs/msg/Header")
    )
    with Writer(path, version=9) as writer:
        left, right, force = (
            writer.add_connection(topic, kind.__msgtype__, typestore=store)
            for topic, kind in (
                ("/left/joint_states", state),
                ("/right/joint_states", state),
                ("/force", vector),
            )
        )
        for k, stamp in enumerate(int(s) for s in truth.stamp):
            head = header(time(stamp // 10**9, stamp % 10**9), "")
            values = truth.q[k], truth.dq[k], truth.tau[k]
            for topic, names in ((left, JOINTS), (right, [f"r_{name}" for name in JOINTS])):
                message = state(head, list(names), *values)
                writer.write(topic, stamp, store.serialize_cdr(message, state.__msgtype__))
            push = store.serialize_cdr(vector(0.0, 0.0, 1.0), vector.__msgtype__)
            writer.write(force, stamp, push)
    return path
