"""Numbers and elements of robot files: every digit of a double, and readable indentation."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw, RotationMatrix

from oed.report.json_file import write_atomically


def number(value: float) -> str:
    """The shortest text that reads back as the same double."""
    return repr(float(value) + 0.0)  # -0.0 becomes 0.0


def numbers(values: Iterable[float]) -> str:
    """Numbers with blanks between."""
    return " ".join(number(value) for value in values)


def roll_pitch_yaw(rotation: Float[ndarray, "3 3"]) -> str:
    """Fixed-axis angles [rad]."""
    return numbers(RollPitchYaw(RotationMatrix(rotation)).vector())


def quaternion(rotation: Float[ndarray, "3 3"]) -> Float[ndarray, "4"]:
    """Unit quaternion, scalar first."""
    found: Quaternion = RotationMatrix(rotation).ToQuaternion()
    return np.array(found.wxyz())


def write_xml(path: Path, root: ElementTree.Element) -> None:
    """Write an indented document, whole or not at all."""
    ElementTree.indent(root, "  ")
    text = ElementTree.tostring(root, encoding="unicode")
    write_atomically(path, f'<?xml version="1.0"?>\n{text}\n')
