"""What `ros2 topic echo --csv` writes of a sensor_msgs/msg/JointState: a line a message, no header.

Each line holds sec, nanosec, frame_id, the n names of the joints, then n positions, n velocities and
n efforts, of which any may be left out by whoever publishes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from oed.experiment.logs.csv_fault import NUMBER

BEFORE_NAMES = 3  # sec, nanosec, frame_id
FIELDS = ("position", "velocity", "effort")
SEC, NANOSEC = "stamp.sec", "stamp.nanosec"


@dataclass(frozen=True)
class EchoLayout:
    """Names of the cells of a line.

    Attributes:
        header: One for each cell.
        joints: The joints' names, which every line must repeat.
    """

    header: tuple[str, ...]
    joints: tuple[str, ...]

    @property
    def names_at(self) -> range:
        """Cells that hold the joints' names."""
        return range(BEFORE_NAMES, BEFORE_NAMES + len(self.joints))


def echo_layout(line: str) -> EchoLayout | None:
    """The layout of a line; None if it is no such message."""
    cells = [cell.strip() for cell in line.split(",")]
    if len(cells) <= BEFORE_NAMES or not all(cell.isdigit() for cell in cells[:2]):
        return None
    is_number = np.array([NUMBER.fullmatch(cell) is not None for cell in cells[BEFORE_NAMES:]])
    n = int(is_number.argmax())
    fields, rest = divmod(len(is_number) - n, n) if n else (0, 0)
    if not n or rest or not 0 < fields <= len(FIELDS) or not is_number[n:].all():
        return None
    joints = tuple(cells[BEFORE_NAMES : BEFORE_NAMES + n])
    header = (
        *(SEC, NANOSEC, "frame_id"),
        *(f"name[{i}]" for i in range(n)),
        *(f"{field}.{joint}" for field in FIELDS[:fields] for joint in joints),
    )
    return EchoLayout(header, joints)
