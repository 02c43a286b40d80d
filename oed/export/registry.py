"""Which form of a model goes by which name; users add their own.

An exporter is a function of a model and a folder. It is registered by `exporter`, or found in the
entry points of installed packages under `oed.exporters`, whose modules do the same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from oed.dynamics.online import Offline
from oed.export.model import Model
from oed.registered import Registered


@dataclass(frozen=True)
class Target:
    """Where an export goes.

    Attributes:
        folder: To write to.
        home: Folder that the files are moved to when all are whole.
        step: Between two instants of a controller or a simulation [s].
    """

    folder: Path
    home: Path
    step: float


@dataclass(frozen=True)
class Exported:
    """What was written.

    Attributes:
        files: Names in the folder, the one to begin with first.
        use: How to use them, in a line.
        left_out: Effects that they do not have, each with the reason.
        notes: What else differs from the model.
    """

    files: tuple[str, ...]
    use: str
    left_out: tuple[Offline, ...] = ()
    notes: tuple[str, ...] = ()


Exporter = Callable[[Model, Target], Exported]
Given = TypeVar("Given", bound=Exporter)

OWN = ("numpy", "casadi", "c", "urdf", "sdf", "mjcf", "mujoco", "drake", "ros2")
EXPORTERS = Registered[Exporter](
    "form",
    "oed.exporters",
    {name: f"oed.export.kinds.to_{name}:write" for name in OWN},
    purpose=" to export to",
)


def exporter(name: str) -> Callable[[Given], Given]:
    """Register an exporter under a name that `oed export --to` accepts; a later one replaces it."""
    return EXPORTERS.add(name)


def find_exporter(name: str) -> Exporter:
    """The exporter of a name.

    Raises:
        ValueError: If there is none.
    """
    return EXPORTERS.find(name)
