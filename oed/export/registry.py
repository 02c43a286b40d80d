"""Which form of a model goes by which name; users add their own.

An exporter is a function of a model and a folder. It is registered by `exporter`, or found in the
entry points of installed packages under `oed.exporters`, whose modules do the same.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import TypeVar

from oed.dynamics.online import Offline
from oed.export.model import Model


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

ENTRY_POINTS = "oed.exporters"
# Modules with a function `write` of that name's form, imported when the first is asked for.
OWN = {
    name: f"oed.export.kinds.to_{name}"
    for name in ("numpy", "casadi", "c", "urdf", "sdf", "mjcf", "mujoco", "drake", "ros2")
}
_exporters: dict[str, Exporter] = {}


def exporter(name: str) -> Callable[[Given], Given]:
    """Register an exporter under a name that `oed export --to` accepts; a later one replaces it."""
    if not name.strip():
        raise ValueError("an exporter needs a name")

    def register(function: Given) -> Given:
        _exporters[name] = function
        return function

    return register


def known_exporters() -> tuple[str, ...]:
    """Names that can be asked for."""
    _load_entry_points()
    return tuple(dict.fromkeys((*OWN, *_exporters)))


def find_exporter(name: str) -> Exporter:
    """The exporter of a name.

    Raises:
        ValueError: If there is none.
    """
    if name not in known_exporters():
        raise ValueError(f"no form {name!r} to export to; known are {', '.join(known_exporters())}")
    if name in _exporters:
        return _exporters[name]
    return importlib.import_module(OWN[name]).write


@cache
def _load_entry_points() -> None:
    for point in entry_points(group=ENTRY_POINTS):
        point.load()
