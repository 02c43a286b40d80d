"""Spoilt inputs of the commands: every case follows from its number."""

from __future__ import annotations

import os
import random
from dataclasses import dataclass
from pathlib import Path

from tests.studies.sound_inputs import MANIFEST, ROBOTS, URDF, recording
from tests.studies.spoiling import COMMON, TABLE, XML

# How often of each.
COMMANDS = {
    "cross-check": 9,
    "design": 4,
    "import": 4,
    "check": 2,
    "identify": 4,
    "feasible": 1,
    "diagnose": 1,
}
INSTEAD = ("pipe", "device", "folder", "nothing", "empty", "huge")


@dataclass(frozen=True)
class Case:
    """One run of a command.

    Attributes:
        command: Name of the study.
        arguments: Of it, "{in}" standing for the folder of the inputs.
        spoilt: What was done to which file, for the report.
    """

    command: str
    arguments: tuple[str, ...]
    spoilt: str


def make_case(number: int, folder: Path) -> Case:
    """Write the inputs of a case into an empty folder, spoilt."""
    rng = random.Random(number)  # noqa: S311  # spoilt files are no secrets
    command = rng.choices(list(COMMANDS), weights=list(COMMANDS.values()))[0]
    with_data = command in ("check", "identify", "feasible", "diagnose") or (
        command == "design" and rng.random() < 0.25
    )
    files: dict[str, str] = {}
    if with_data:
        files = {
            "dataset.toml": MANIFEST,
            "estimation.csv": recording(0),
            "validation.csv": recording(1),
        }
        if rng.random() < 0.5:
            files["robot.urdf"] = URDF
            files["dataset.toml"] = MANIFEST.replace("builtin:imi_scara", "robot.urdf")
    elif command == "import":
        files = {"estimation.csv": recording(0), "robot.urdf": URDF}
    else:
        name = rng.choices(list(ROBOTS), weights=(6, 2, 2, 2, 1))[0]
        files = {name: ROBOTS[name]}
    told = _spoil(files, folder, rng)
    file = f"{{in}}/{next(iter(files))}"
    source = ("{in}",) if with_data else (file,)
    if command == "design":
        source = ("--data" if with_data else "--robot", *source)
    if command == "import":
        source = (*source, "--robot", "{in}/robot.urdf")
    more = rng.choices(
        [(), ("--joints", "joint_2"), ("--joints", "nobody"), ("--joints", "joint_1", "joint_1")],
        weights=(12, 2, 1, 1),
    )[0]
    if command == "cross-check":
        return Case(command, (*source, "--states", "50"), told)
    less = ("--smoke",) if command in ("design", "feasible", "diagnose") else ()
    return Case(command, (*source, *less, *(() if command == "diagnose" else more)), told)


def _spoil(files: dict[str, str], folder: Path, rng: random.Random) -> str:
    told = []
    for name, text in files.items():
        content: str | bytes = text
        if len(files) == 1 or rng.random() < 0.45:
            if rng.random() < 0.08:
                kind = rng.choice(INSTEAD)
                _put_instead(folder / name, kind)
                told.append(f"{name}: {kind}")
                continue
            known = TABLE if name.endswith(".csv") else COMMON if name.endswith(".toml") else XML
            for _ in range(rng.choices((1, 2, 3), weights=(6, 2, 1))[0]):
                if not isinstance(content, str):
                    break
                spoil = rng.choice(known)
                try:
                    content = spoil(content, rng)
                except (ValueError, IndexError):
                    continue  # the file is spoilt beyond this way of spoiling
                told.append(f"{name}: {spoil.__name__[1:]}")
        written = content if isinstance(content, bytes) else content.encode(errors="replace")
        (folder / name).write_bytes(written)
    return "; ".join(told) or "nothing"


def _put_instead(path: Path, kind: str) -> None:
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "folder":
        path.mkdir()
    elif kind == "empty":
        path.write_bytes(b"")
    elif kind == "huge":
        with path.open("wb") as file:
            file.truncate(10**12)
