"""ROS bags: rosbag2 as SQLite or MCAP, and ROS 1 bags, read by the library rosbags.

Each topic that carries joint states is one table; messages of one topic that name other joints,
such as those of a gripper, are one of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy import ndarray

from oed.errors import DataSetError
from oed.experiment.logs.registry import log_reader
from oed.experiment.logs.stamps import seconds_of_day
from oed.experiment.logs.table import Log, Table, table_of

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader

STATE = "sensor_msgs/msg/JointState"
DYNAMIC = "control_msgs/msg/DynamicJointState"
CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
# Bags of ROS 2 Humble and before do not carry their definitions; these two have never changed.
# ros-controls/control_msgs, msg/DynamicJointState.msg and msg/InterfaceValue.msg.
DEFINITIONS = {
    DYNAMIC: "std_msgs/Header header\nstring[] joint_names\ncontrol_msgs/InterfaceValue[] interface_values",
    "control_msgs/msg/InterfaceValue": "string[] interface_names\nfloat64[] values",
}
# The state that was measured: "actual" before ROS 2 Humble renamed it.
MEASURED_POINTS = ("feedback", "actual")


class _Sample(NamedTuple):
    """One message: where it came from, its two times [ns], and its numbers by column."""

    topic: str
    columns: tuple[str, ...]
    received: int
    stamp: int
    values: tuple[float, ...]


@log_reader(".db3", ".mcap", ".bag")
def read_bag(path: Path) -> Log:
    """Read the joint states of a bag: a file, or the folder of a rosbag2.

    Columns are `topic.field.joint`, such as `/joint_states.effort.elbow`; `topic.stamp` is the time
    in the header and `topic.received` the time at which the recorder got the message, both in
    seconds since midnight (UTC) of the first.

    Raises:
        DataSetError: If the bag is damaged or carries no joint states.
    """
    file = str(path)
    try:
        from rosbags.highlevel import AnyReader  # noqa: PLC0415  only bags need it
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore  # noqa: PLC0415
    except ImportError as error:
        message = f"needs the package rosbags ({error}); install it with: pip install 'oed[ros]'"
        raise DataSetError(message, file=file) from error
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    try:
        with AnyReader([path], default_typestore=store) as reader:
            topics = sorted({(c.topic, c.msgtype) for c in reader.connections})
            samples = list(_samples(reader, file))
    except DataSetError:
        raise
    except Exception as error:
        # A damaged bag fails in rosbags, and in what it is made of, in countless ways.
        message = f"is no sound bag: {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        raise DataSetError(message, file=file) from error
    if not samples:
        found = ", ".join(f"{topic} ({kind})" for topic, kind in topics[:8]) or "no topic"
        message = f"carries no joint states ({', '.join(KINDS)}); it holds {found}"
        raise DataSetError(message, file=file)
    groups: dict[tuple[str, frozenset[str]], list[_Sample]] = {}
    for sample in samples:
        groups.setdefault((sample.topic, frozenset(sample.columns)), []).append(sample)
    tables = [_table(group, file) for group in groups.values()]
    others = tuple(f"topic {topic} ({kind})" for topic, kind in topics if kind not in KINDS)
    return Log(file, tuple(sorted(tables, key=lambda table: -len(table.columns))), others)


def _samples(reader: AnyReader, file: str) -> Iterator[_Sample]:
    wanted = [connection for connection in reader.connections if connection.msgtype in KINDS]
    if not wanted:
        return
    for i, (connection, received, raw) in enumerate(reader.messages(connections=wanted)):
        message = reader.deserialize(raw, connection.msgtype)
        try:
            named = dict(KINDS[connection.msgtype](message))
        except ValueError as error:
            what = f"message {i + 1} of {connection.topic}: {error}"
            raise DataSetError(what, file=file, row=i + 1) from error
        stamp = message.header.stamp
        yield _Sample(
            connection.topic,
            tuple(named),
            received,
            stamp.sec * 10**9 + stamp.nanosec,
            tuple(named.values()),
        )


def _table(samples: Sequence[_Sample], file: str) -> Table:
    """The table of the messages of one topic that name the same joints, in whatever order."""
    topic, columns = samples[0].topic, samples[0].columns
    if all(sample.columns == columns for sample in samples):
        values = np.array([sample.values for sample in samples])
    else:
        by_name = [dict(zip(sample.columns, sample.values, strict=True)) for sample in samples]
        values = np.array([[named[column] for column in columns] for named in by_name])
    arrays = {
        f"{topic}.stamp": seconds_of_day(np.array([s.stamp for s in samples])),
        f"{topic}.received": seconds_of_day(np.array([s.received for s in samples])),
    }
    arrays |= {f"{topic}.{column}": values[:, i] for i, column in enumerate(columns)}
    return table_of(arrays, file, name=topic)


def _state(message: Any) -> Iterator[tuple[str, float]]:
    for name in ("position", "velocity", "effort"):
        yield from _by_joint(name, message.name, getattr(message, name))


def _dynamic(message: Any) -> Iterator[tuple[str, float]]:
    if len(message.joint_names) != len(message.interface_values):
        raise ValueError(
            f"{len(message.joint_names)} joints, but interfaces of {len(message.interface_values)}"
        )
    for joint, interface in zip(message.joint_names, message.interface_values, strict=True):
        names, values = interface.interface_names, interface.values
        if len(names) != len(values):
            raise ValueError(f"{len(names)} interfaces of {joint!r}, but {len(values)} values")
        yield from ((f"{name}.{joint}", float(v)) for name, v in zip(names, values, strict=True))


def _controller(message: Any) -> Iterator[tuple[str, float]]:
    measured = next((name for name in MEASURED_POINTS if hasattr(message, name)), None)
    if measured is None:
        raise ValueError(f"no field {' or '.join(MEASURED_POINTS)}")
    point = getattr(message, measured)
    for name in ("positions", "velocities", "accelerations", "effort"):
        yield from _by_joint(name, message.joint_names, getattr(point, name))


def _by_joint(field: str, joints: Sequence[str], values: ndarray) -> Iterator[tuple[str, float]]:
    """What a list of one number a joint tells; nothing if it is empty."""
    if len(values) and len(values) != len(joints):
        raise ValueError(f"{len(joints)} names, but {len(values)} values of {field}")
    if len(values):
        yield from ((f"{field}.{joint}", float(v)) for joint, v in zip(joints, values, strict=True))


# What each type of message tells, as pairs of a column's name and a number.
KINDS: dict[str, Callable[[Any], Iterator[tuple[str, float]]]] = {
    STATE: _state,
    DYNAMIC: _dynamic,
    CONTROLLER: _controller,
}
