"""One simulated arm, logged in the ways that laboratories have, by the real libraries."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.io import savemat

from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import rigid_body_torque
from oed.robot import Robot

JOINTS = ("shoulder", "elbow", "wrist")
URDF = """\
<robot name="arm">
  <link name="base"/>
{links}
</robot>
"""
LINK = """\
  <joint name="{name}" type="revolute">
    <parent link="{parent}"/><child link="{name}_link"/>
    <origin xyz="0 0 -0.3"/><axis xyz="0 1 0"/>
    <limit lower="-2.5" upper="2.5" velocity="8" effort="60"/>
  </joint>
  <link name="{name}_link"><inertial>
    <origin xyz="0.02 0 -0.15"/><mass value="{mass}"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/>
  </inertial></link>
"""
TORQUE_CONSTANT = (11.0, 9.0, 7.5)  # [N m/A]
START = 1_760_000_000 * 10**9  # [ns] since 1970


@dataclass(frozen=True)
class Truth:
    """What the arm did: `stamp` (N,) [ns], `t` (N,) [s], `q`, `dq` and `tau` (N, 3)."""

    stamp: np.ndarray
    t: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    tau: np.ndarray


def write_urdf(path: Path) -> Path:
    """The arm's file: three joints about parallel axes, hanging."""
    parents = ("base", *(f"{name}_link" for name in JOINTS))
    links = "".join(
        LINK.format(name=name, parent=parent, mass=mass)
        for name, parent, mass in zip(JOINTS, parents, (3.0, 2.0, 1.0), strict=False)
    )
    path.write_text(URDF.format(links=links))
    return path


def simulate(robot: Robot, *, rows: int = 2400, rate: float = 100.0) -> Truth:
    """A motion of three incommensurate harmonics a joint, its torque, and some noise on both."""
    rng = np.random.default_rng(60)
    steps = np.arange(rows)
    t = steps / rate
    omega = 2 * np.pi * rng.uniform(0.1, 0.6, (3, 3))
    size, phase = rng.uniform(0.15, 0.4, (3, 3)), rng.uniform(0, 2 * np.pi, (3, 3))
    angle = t[:, None, None] * omega + phase
    q = np.sum(size * np.sin(angle), axis=2)
    dq = np.sum(size * omega * np.cos(angle), axis=2)
    ddq = -np.sum(size * omega**2 * np.sin(angle), axis=2)
    rigid = rigid_body_torque(robot, Motion(t, q, dq, ddq))
    tau = rigid + 0.2 * np.sign(dq) + 0.4 * dq + rng.normal(0, 0.02, q.shape)
    return Truth(START + steps * round(1e9 / rate), t, q, dq, tau)


def echo_csv(truth: Truth, folder: Path) -> Path:
    """As `ros2 topic echo --csv /joint_states` prints it."""
    path = folder / "echo.csv"
    with path.open("w") as file:
        for k, stamp in enumerate(truth.stamp):
            cells = [stamp // 10**9, stamp % 10**9, "", *JOINTS]
            cells += [repr(float(v)) for row in (truth.q, truth.dq, truth.tau) for v in row[k]]
            file.write(",".join(map(str, cells)) + "\n")
    return path


def rtde_frame(truth: Truth) -> pd.DataFrame:
    """Fields of Universal Robots' real-time interface."""
    columns = {"timestamp": truth.t}
    for j in range(3):
        columns[f"target_q_{j}"] = truth.q[:, j] + 1e-3
    for name, values in (
        ("actual_q", truth.q),
        ("actual_qd", truth.dq),
        ("actual_current", truth.tau / TORQUE_CONSTANT),
        ("target_moment", truth.tau * 0.9),
    ):
        columns |= {f"{name}_{j}": values[:, j] for j in range(3)}
    return pd.DataFrame(columns)


def rtde_commas(truth: Truth, folder: Path) -> Path:
    rtde_frame(truth).to_csv(folder / "rtde.csv", index=False)
    return folder / "rtde.csv"


def rtde_blanks(truth: Truth, folder: Path) -> Path:
    rtde_frame(truth).to_csv(folder / "rtde_blanks.csv", index=False, sep=" ")
    return folder / "rtde_blanks.csv"


def rtde_parquet(truth: Truth, folder: Path) -> Path:
    rtde_frame(truth).to_parquet(folder / "rtde.parquet")
    return folder / "rtde.parquet"


def spreadsheet(truth: Truth, folder: Path) -> Path:
    """Semicolons, decimal commas, a byte-order mark, degrees, units in the header."""
    columns = {"Time [ms]": 1e3 * truth.t}
    for name, unit, values in (
        ("Angle", "deg", np.rad2deg(truth.q)),
        ("Speed", "rpm", truth.dq * 60 / (2 * np.pi)),
        ("Torque", "mNm", 1e3 * truth.tau),
    ):
        columns |= {f"{name} {j + 1} [{unit}]": values[:, j] for j in range(3)}
    path = folder / "spreadsheet.csv"
    text = pd.DataFrame(columns).to_csv(index=False, sep=";", decimal=",", lineterminator="\r\n")
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    return path


def joint_frame(truth: Truth, times: pd.Series, names: str) -> pd.DataFrame:
    """Times as they are, then degrees, degrees a second and newton metres a joint.

    Args:
        times: Of the rows, under the name of their column.
        names: Of the others: quantity, number of the joint, unit.
    """
    columns = {str(times.name): times}
    for name, unit, values in (
        ("q", "deg", np.rad2deg(truth.q)),
        ("dq", "deg/s", np.rad2deg(truth.dq)),
        ("tau", "Nm", truth.tau),
    ):
        columns |= {names.format(name, j + 1, unit): values[:, j] for j in range(3)}
    return pd.DataFrame(columns)


def unicode_text(truth: Truth, folder: Path) -> Path:
    """A spreadsheet's Unicode text: UTF-16, tabs, decimal commas; ISO 8601, units after a slash."""
    stamps = pd.Series(pd.to_datetime(truth.stamp), name="time").dt
    times = stamps.strftime("%Y-%m-%d %H:%M:%S,%f").rename("time")
    text = joint_frame(truth, times, "{} {} / {}").to_csv(
        index=False, sep="\t", decimal=",", lineterminator="\r\n"
    )
    path = folder / "unicode.txt"
    path.write_text(text, encoding="utf-16", newline="")
    return path


def times_of_day(truth: Truth, folder: Path) -> Path:
    """A logger's CSV that runs through midnight, with a line of units below the names."""
    midnight = pd.Timestamp("2026-01-01")
    times = midnight - pd.Timedelta("5s") + pd.to_timedelta(truth.stamp - truth.stamp[0])
    clock = pd.Series(times.strftime("%H:%M:%S.%f").str[:-3], name="time")
    frame = joint_frame(truth, clock, "{}{}|{}")
    names, units = zip(*(f"{name}|".split("|")[:2] for name in frame.columns), strict=True)
    path = folder / "clock.csv"
    rows = frame.to_csv(index=False, header=False)
    path.write_text(f"{','.join(names)}\n{','.join(units)}\n{rows}")
    return path


def lerobot(truth: Truth, folder: Path) -> Path:
    """LeRobot's layout: lists of degrees, motors named in meta/info.json; here with 64 bits."""
    (folder / "meta").mkdir()
    names = {"motors": [f"{name}.pos" for name in JOINTS]}
    features = {
        key: {"dtype": "float64", "shape": [3], "names": names}
        for key in ("observation.state", "observation.velocity", "observation.effort", "action")
    }
    (folder / "meta" / "info.json").write_text(json.dumps({"fps": 100, "features": features}))
    path = folder / "data" / "chunk-000" / "episode_000000.parquet"
    path.parent.mkdir(parents=True)
    lists = {
        "observation.state": np.rad2deg(truth.q),
        "observation.velocity": np.rad2deg(truth.dq),
        "observation.effort": truth.tau,
        "action": np.rad2deg(truth.q) + 0.1,
    }
    table = {
        key: pa.array(values.tolist(), pa.list_(pa.float64(), 3)) for key, values in lists.items()
    }
    table["timestamp"] = pa.array(truth.t)
    table["episode_index"] = pa.array(np.zeros(len(truth.t), dtype=np.int64))
    table["task"] = pa.array(["wave"] * len(truth.t))
    pq.write_table(pa.table(table), path)
    return path


def matlab(truth: Truth, folder: Path) -> Path:
    struct = {"t": truth.t, "q": truth.q, "qd": truth.dq, "tau": truth.tau, "note": "run 3"}
    savemat(folder / "log.mat", {"log": struct})
    return folder / "log.mat"


def numpy_archive(truth: Truth, folder: Path) -> Path:
    np.savez(folder / "log.npz", time=truth.t, qpos=truth.q, qvel=truth.dq, torque=truth.tau)
    return folder / "log.npz"


def hdf5(truth: Truth, folder: Path) -> Path:
    with h5py.File(folder / "log.h5", "w") as file:
        file["state/time"] = truth.t
        file["state/joint_positions"] = truth.q
        file["state/joint_velocities"] = truth.dq
        file["state/joint_torques"] = truth.tau
        file["command/joint_positions"] = truth.q + 0.01
        file["name"] = "run 3"
    return folder / "log.h5"


def bag(truth: Truth, path: Path, plugin: StoragePlugin) -> Path:
    """/joint_states as a bag, joints in the order of the alphabet, and a gripper's beside them."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    state, header = (
        store.types[name] for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header")
    )
    time = store.types["builtin_interfaces/msg/Time"]
    order = [1, 0, 2]
    names = [JOINTS[j] for j in order]
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        topic = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        for k, stamp in enumerate(int(s) for s in truth.stamp):
            head = header(time(stamp // 10**9, stamp % 10**9), "")
            arm = state(head, names, truth.q[k, order], truth.dq[k, order], truth.tau[k, order])
            late = 10**5 * (1 + k % 7)
            writer.write(topic, stamp + late, store.serialize_cdr(arm, state.__msgtype__))
            if k % 10 == 0:
                hand = state(head, ["finger"], np.array([0.01]), np.array([0.0]), np.array([]))
                writer.write(topic, stamp + late, store.serialize_cdr(hand, state.__msgtype__))
    return path


def bag_sqlite(truth: Truth, folder: Path) -> Path:
    return bag(truth, folder / "bag", StoragePlugin.SQLITE3)


def bag_mcap(truth: Truth, folder: Path) -> Path:
    return next(bag(truth, folder / "bag_mcap", StoragePlugin.MCAP).glob("*.mcap"))


LOGS: dict[str, Callable[[Truth, Path], Path]] = {
    "ros2 topic echo --csv": echo_csv,
    "RTDE CSV, commas": rtde_commas,
    "RTDE CSV, blanks": rtde_blanks,
    "RTDE Parquet": rtde_parquet,
    "spreadsheet CSV": spreadsheet,
    "spreadsheet Unicode text": unicode_text,
    "times of day, a line of units": times_of_day,
    "LeRobot Parquet": lerobot,
    "MATLAB": matlab,
    "NumPy": numpy_archive,
    "HDF5": hdf5,
    "rosbag2 SQLite": bag_sqlite,
    "rosbag2 MCAP": bag_mcap,
}
