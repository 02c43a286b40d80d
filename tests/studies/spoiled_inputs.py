"""Spoilt inputs of the commands: every case follows from its number."""

from __future__ import annotations

import os
import random
from dataclasses import dataclass
from pathlib import Path

from tests.studies.sound_inputs import MANIFEST, ROBOTS, URDF, hanging, model, recording
from tests.studies.spoiling import COMMON, TABLE, XML, Spoil

# How often of each.
COMMANDS = {
    "cross-check": 9,
    "design": 4,
    "import": 4,
    "check": 2,
    "identify": 4,
    "feasible": 1,
    "payload": 2,
    "gains": 2,
    "diagnose": 1,
    "calibrate": 0.5,
    "export": 3,
    "demo": 0.25,
}
OF_DATA = ("check", "identify", "feasible", "diagnose", "calibrate")
SMOKE = ("design", "feasible", "diagnose", "calibrate", "demo")
NO_JOINTS = ("cross-check", "diagnose", "calibrate", "export", "demo")
FORMS = ("numpy", "casadi", "c", "urdf", "sdf", "mjcf", "mujoco", "drake", "ros2")
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
    arguments, files = _sound(command, rng)
    told = _spoil(files, folder, rng)
    more = rng.choices(
        [(), ("--joints", "joint_2"), ("--joints", "nobody"), ("--joints", "joint_1", "joint_1")],
        weights=(12, 2, 1, 1),
    )[0]
    less = ("--smoke",) if command in SMOKE else ()
    return Case(command, (*arguments, *less, *(() if command in NO_JOINTS else more)), told)


def _sound(command: str, rng: random.Random) -> tuple[tuple[str, ...], dict[str, str]]:
    """Arguments of a command, and the files that they name."""
    if command in ("payload", "gains"):
        return _with_a_load(command, rng)
    if command == "export":
        forms = rng.sample(FORMS, rng.randint(1, 3))
        samples = rng.choice([(), ("--samples", "3")])
        return ("{in}", "--to", *forms, *samples), {"model.json": model()}
    if command == "demo":
        return ("--seed", str(rng.randrange(1000))), {}
    if command == "import":
        files = {"estimation.csv": recording(0), "robot.urdf": URDF}
        return ("{in}/estimation.csv", "--robot", "{in}/robot.urdf"), files
    if command in OF_DATA or (command == "design" and rng.random() < 0.25):
        files = {
            "dataset.toml": MANIFEST,
            "estimation.csv": recording(0),
            "validation.csv": recording(1),
        }
        if rng.random() < 0.5:
            files["robot.urdf"] = URDF
            files["dataset.toml"] = MANIFEST.replace("builtin:imi_scara", "robot.urdf")
        return (("--data", "{in}") if command == "design" else ("{in}",)), files
    name = rng.choices(list(ROBOTS), weights=(6, 2, 2, 2, 1))[0]
    source = (f"{{in}}/{name}",)
    if command == "cross-check":
        source = (*source, "--states", "50")
    return (("--robot", *source) if command == "design" else source), {name: ROBOTS[name]}


def _with_a_load(command: str, rng: random.Random) -> tuple[tuple[str, ...], dict[str, str]]:
    files = {f"loaded/{name}": text for name, text in hanging(load=True).items()}
    arguments: tuple[str, ...] = ("--loaded", "{in}/loaded")
    known = "bare" if command == "gains" else rng.choice(["bare", "model", "file"])
    if known == "bare":
        files |= {f"bare/{name}": text for name, text in hanging(load=False).items()}
        arguments += ("--bare", "{in}/bare")
    elif known == "model":
        files["model.json"] = model()
        arguments += ("--model", "{in}/model.json")
    if command == "gains":
        currents = 'torque = "current"\nunits = {tau = "A"}'
        files = {n: t.replace('torque = "measured"', currents) for n, t in files.items()}
        arguments += rng.choice([(), ("--mass", "1.5"), ("--mass", "1.5", "--com", "0", "0", "0")])
    return arguments, files


def _spoil(files: dict[str, str], folder: Path, rng: random.Random) -> str:
    told = []
    for name, text in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        content: str | bytes = text
        if len(files) == 1 or rng.random() < 0.45:
            if rng.random() < 0.08:
                kind = rng.choice(INSTEAD)
                _put_instead(folder / name, kind)
                told.append(f"{name}: {kind}")
                continue
            known = _ways(name)
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


def _ways(name: str) -> tuple[Spoil, ...]:
    if name.endswith(".csv"):
        return TABLE
    return COMMON if name.endswith((".toml", ".json")) else XML


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
