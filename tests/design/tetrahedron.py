"""A mesh whose volume is known, as files, and robots made of such."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from numpy import ndarray

# Edges of 3, 4 and 5 along the axes: its volume is 3 * 4 * 5 / 6. Exact in single precision.
CORNERS = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0], [0, 0, 5]])


FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


TETRAHEDRON = CORNERS[FACES]


VOLUME = 10.0


def write_binary_stl(triangles: ndarray, path: Path, header: bytes = b"") -> Path:
    """80 bytes, the count, and of each triangle a normal, three corners and two spare bytes."""
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *t.reshape(-1), 0) for t in triangles)
    path.write_bytes(header.ljust(80) + struct.pack("<I", len(triangles)) + body)
    return path


def robot_text(*elements: str, materials: str = "") -> str:
    return f'<robot name="r">{materials}<link name="a">{"".join(elements)}</link></robot>'
