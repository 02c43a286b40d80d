"""A tiny valid data set of the built-in SCARA, as text, to be spoilt by tests and refused."""

from pathlib import Path

import numpy as np
import pytest

from oed.errors import DataSetError
from oed.experiment.read_dataset import read_dataset

ROWS = 30
HEADER = "t,q_1,q_2,tau_1,tau_2"
MANIFEST = """\
format = 1
name = "tiny"
source = "a formula"
licence = "CC0"
robot = "builtin:imi_scara"
joints = ["joint_1", "joint_2"]
gravity = [0.0, 0.0, -9.81]
torque = "measured"

[[recording]]
file = "estimation.csv"
role = "estimation"
repetitions = 3
period = 1.0

[[recording]]
file = "test.csv"
role = "test"
"""


def csv_text(seed: int, rows: int = ROWS) -> str:
    """A recording of `rows` rows, 0.1 s apart, whose positions repeat every second."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1, 1, (10, 2))
    lines = [HEADER]
    for k in range(rows):
        cells = [k / 10, *q[k % 10], *rng.uniform(-1, 1, 2)]
        lines.append(",".join(f"{cell:.7g}" for cell in cells))
    return "\n".join(lines) + "\n"


def tiny_files() -> dict[str, bytes]:
    """The content of each file of the data set, by name."""
    return {
        "dataset.toml": MANIFEST.encode(),
        "estimation.csv": csv_text(0).encode(),
        "test.csv": csv_text(1).encode(),
    }


def write_files(folder: Path, files: dict[str, bytes]) -> Path:
    """Write the files and return their folder."""
    folder.mkdir(exist_ok=True)
    for name, content in files.items():
        (folder / name).write_bytes(content)
    return folder


def spoil(folder: Path, name: str, old: str, new: str) -> Path:
    """The tiny data set with `old` replaced by `new` in one of its files."""
    files = tiny_files()
    text = files[name].decode()
    assert old in text, f"{old!r} is not in {name}"
    files[name] = text.replace(old, new).encode()
    return write_files(folder, files)


def with_line(folder: Path, row: int, line: str | None) -> Path:
    """The tiny data set with line `row` (the header is 1) of estimation.csv replaced or cut."""
    files = tiny_files()
    lines = files["estimation.csv"].decode().splitlines()
    lines[row - 1 : row] = [] if line is None else [line]
    files["estimation.csv"] = ("\n".join(lines) + "\n").encode()
    return write_files(folder, files)


URDF = """\
<robot name="pendulum">
  <link name="base"/>
  {links}
</robot>
"""
URDF_JOINT = """\
  <joint name="joint_{i}" type="revolute">
    <parent link="{parent}"/><child link="link_{i}"/>
    <origin xyz="0.3 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="4" effort="10"/>
  </joint>
  <link name="link_{i}"><inertial>
    <mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>
  </inertial></link>
"""


def urdf_text(joints: int) -> str:
    """A planar chain of revolute joints joint_1 … joint_n."""
    links = "".join(
        URDF_JOINT.format(i=i, parent=f"link_{i - 1}" if i > 1 else "base")
        for i in range(1, joints + 1)
    )
    return URDF.format(links=links)


def with_urdf(folder: Path, joints: int) -> Path:
    """The data set with a URDF of that many joints; the manifest goes on listing two."""
    files = tiny_files()
    files["dataset.toml"] = MANIFEST.replace("builtin:imi_scara", "robot.urdf").encode()
    files["robot.urdf"] = urdf_text(joints).encode()
    return write_files(folder, files)


def refused(folder: Path, **chosen) -> DataSetError:
    """The error that reading the folder ends in; the folder must stay as it was."""
    before = sorted((path, path.stat().st_mtime_ns) for path in folder.rglob("*"))
    with pytest.raises(DataSetError) as caught:
        read_dataset(folder, **chosen)
    assert sorted((path, path.stat().st_mtime_ns) for path in folder.rglob("*")) == before
    error = caught.value
    assert error.file in str(error)
    assert error.row is None or f"row {error.row}" in str(error)
    assert error.column is None or error.column in str(error)
    return error
