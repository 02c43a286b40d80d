"""Small valid inputs of the commands, and ways to spoil them: every case follows from its number."""

from __future__ import annotations

import os
import random
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import rigid_body_torque
from oed.robot import imi_scara
from tests.robot.test_description import TAIL
from tests.robot.test_mjcf_file import ARM as MJCF
from tests.robot.test_xacro_file import HEAD, LENGTH

URDF = """\
<robot name="arm">
  <link name="base"/>
  <joint name="joint_1" type="revolute"><parent link="base"/><child link="link_1"/>
    <origin xyz="0 0 0.1" rpy="0 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2.5" upper="2.5" velocity="4" effort="60"/></joint>
  <link name="link_1"><inertial><origin xyz="0.2 0 0.02"/><mass value="3"/>
    <inertia ixx="0.02" iyy="0.05" izz="0.05" ixy="0.001" ixz="0.002" iyz="0"/></inertial></link>
  <joint name="joint_2" type="revolute"><parent link="link_1"/><child link="link_2"/>
    <origin xyz="0.4 0 0" rpy="1.5708 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="5" effort="40"/></joint>
  <link name="link_2"><inertial><origin xyz="0.15 0.01 0"/><mass value="1.5"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0.001" iyz="0"/></inertial></link>
</robot>
"""
SDF = """\
<sdf version="1.9"><model name="arm"><link name="base"/>
  <link name="upper"><pose relative_to="turn">0 0 0 0 0 0</pose><inertial>
    <pose>0.1 0 0 0 0 0</pose><mass>2</mass><inertia><ixx>0.02</ixx><iyy>0.03</iyy><izz>0.04</izz>
    </inertia></inertial></link>
  <joint name="turn" type="revolute"><pose relative_to="base">0 0 0.1 0 0.4 0</pose>
    <parent>base</parent><child>upper</child><axis><xyz>0 0.6 0.8</xyz>
    <limit><lower>-1</lower><upper>1</upper><velocity>3</velocity></limit></axis></joint>
</model></sdf>
"""
DH = """\
convention = "standard"
[[joint]]
a = 0.3
alpha = 1.5708
d = 0.1
lower = -2.0
upper = 2.0
velocity = 3.0
effort = 50.0
mass = 2.0
com = [-0.1, 0.0, 0.0]
inertia = [0.01, 0.0, 0.0, 0.02, 0.0, 0.02]
[[joint]]
a = 0.2
alpha = 0.0
kind = "prismatic"
lower = 0.0
upper = 0.3
"""
MANIFEST = """\
format = 1
name = "small"
source = "a formula"
licence = "CC0"
robot = "builtin:imi_scara"
joints = ["joint_1", "joint_2"]
gravity = [0.0, 0.0, -9.81]
torque = "measured"

[[recording]]
file = "estimation.csv"
role = "estimation"
repetitions = 4
period = 2.0

[[recording]]
file = "validation.csv"
role = "validation"
"""
ROBOTS = {
    "robot.urdf": URDF,
    "arm.xml": MJCF.format(assets="", geom=""),
    "arm.sdf": SDF,
    "dh.toml": DH,
    "arm.urdf.xacro": URDF.replace('<robot name="arm">', HEAD + LENGTH).replace(
        '"0.4 0', '"${l} 0'
    ),
}
RATE = 50.0  # [Hz]


@cache
def recording(seed: int) -> str:
    """Four repetitions of two seconds of the built-in arm, with friction and noise, as CSV."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 8, 1 / RATE)
    q, dq, ddq = (np.zeros((len(t), 2)) for _ in range(3))
    for k in range(1, 5):
        w, (a, b) = k * np.pi, rng.uniform(-0.3, 0.3, (2, 2)) / k
        q += a * np.sin(w * t)[:, None] + b * np.cos(w * t)[:, None]
        dq += w * (a * np.cos(w * t)[:, None] - b * np.sin(w * t)[:, None])
        ddq -= w**2 * (a * np.sin(w * t)[:, None] + b * np.cos(w * t)[:, None])
    tau = rigid_body_torque(imi_scara(), Motion(t, q, dq, ddq))
    tau += 2.0 * np.sign(dq) + 3.0 * dq + rng.normal(0, 0.1, tau.shape)
    rows = np.column_stack([t, q, tau])
    lines = [",".join(f"{x:.7g}" for x in row) for row in rows]
    return "t,q_1,q_2,tau_1,tau_2\n" + "\n".join(lines) + "\n"


Spoil = Callable[[str, random.Random], str | bytes]
NUMBER = re.compile(r"(?<![\w.])-?\d+(\.\d+)?([eE]-?\d+)?")
VALUES = (
    "nan",
    "inf",
    "-inf",
    "0",
    "-1",
    "1e400",
    "1e12",
    "1e-320",
    "",
    "0,5",
    "x",
    "9" * 400,
    "0x1",
    "${l}",
)


def _number(text: str, rng: random.Random) -> str:
    found = list(NUMBER.finditer(text))
    if not found:
        return text
    at = rng.choice(found)
    value = float(at[0])
    scaled = [repr(value * factor) for factor in (-1, 57.3, 1e-3, 1e3, 1e6, 1.5)]
    return text[: at.start()] + rng.choice([*VALUES, *scaled]) + text[at.end() :]


def _cut(text: str, rng: random.Random) -> str:
    return text[: rng.randrange(len(text) + 1)]


def _lines(text: str, rng: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    i, j = (rng.randrange(len(lines)) for _ in range(2)) if lines else (0, 0)
    what = rng.randrange(4)
    if what == 0 and lines:
        lines[i], lines[j] = lines[j], lines[i]
    elif what == 1 and lines:
        del lines[i]
    elif what == 2 and lines:
        lines.insert(i, lines[j])
    else:
        rng.shuffle(lines)
    return "".join(lines)


def _letters(text: str, rng: random.Random) -> str:
    for _ in range(rng.randint(1, 6)):
        at = rng.randrange(len(text) + 1)
        text = (
            text[:at]
            + rng.choice("<>\"'&;,=[]{}()\0\u00e9\u2212 \n\t0a$")
            + text[at + rng.randint(0, 1) :]
        )
    return text


def _encoded(text: str, rng: random.Random) -> bytes:
    kind = rng.choice(["utf-16", "latin-1", "utf-8-sig", "utf-32", "cp037", "crlf", "flip", "gzip"])
    if kind == "crlf":
        return text.replace("\n", "\r\n").encode()
    if kind == "flip":
        content = bytearray(text.encode())
        for _ in range(rng.randint(1, 20)):
            content[rng.randrange(len(content) or 1)] ^= 1 << rng.randrange(8)
        return bytes(content)
    if kind == "gzip":
        return b"\x1f\x8b\x08\x00" + text.encode()[::-1]
    return text.replace("arm", "\u00e4rm").encode(kind, errors="replace")


def _words(text: str, rng: random.Random) -> str:
    """One word in quotes or between tags takes another's place: parents, children, types, keys."""
    found = list(re.finditer(r'"[^"<>]*"|>[^<>\s]+<', text))
    if len(found) < 2:
        return text
    at, other = rng.sample(found, 2)
    extra = ['"floating"', '"planar"', '"continuous"', '"fixed"', '"prismatic"', '"world"', '""']
    word = rng.choice([other[0], rng.choice(extra)])
    return text[: at.start()] + word + text[at.end() :]


def _nested(text: str, rng: random.Random) -> str:
    depth = rng.choice([5, 150, 3000, 60_000])
    if "<" not in text[:200]:
        return f"deep = {'[' * depth}{']' * depth}\n{text}"
    at = text.index(">") + 1
    return text[:at] + "<a>" * depth + "</a>" * depth + text[at:]


def _elements(text: str, rng: random.Random) -> str:
    """An element is left out, doubled, or put where another is."""
    found = [m for m in re.finditer(r"<(\w+)[^<>]*(/>|>[^<>]*</\1>)", text) if m.end() > m.start()]
    if not found:
        return _lines(text, rng)
    at, other = rng.choice(found), rng.choice(found)
    return text[: at.start()] + rng.choice(["", at[0] * 2, other[0]]) + text[at.end() :]


def _tail(text: str, rng: random.Random) -> str:
    """A joint more, which may close a loop or float."""
    links = ["base", "link_1", "link_2", "end", "nowhere"]
    kind = rng.choice(["revolute", "floating", "planar", "fixed", "continuous", "screw"])
    tail = TAIL.format(kind=kind, parent=rng.choice(links), child=rng.choice(links))
    return text.replace("</robot>", tail)


def _mimic(text: str, rng: random.Random) -> str:
    head = f'<joint name="joint_{rng.randint(1, 2)}" type="revolute">'
    leader = rng.choice(["joint_1", "joint_2", "nobody"])
    return text.replace(head, f'{head}<mimic joint="{leader}" multiplier="{rng.choice(VALUES)}"/>')


def _columns(text: str, rng: random.Random) -> str:
    """Columns of a table are exchanged, scaled, reversed, held still or renamed."""
    lines = [line.split(",") for line in text.splitlines()]
    i, j = rng.sample(range(5), 2) if len(lines[0]) == 5 else (0, 0)
    what = rng.randrange(6)
    if what == 5:
        lines[0][i] = rng.choice(["", "x", "q_9", "q_1", "dq_1", "time", "tau_01"])
        return "\n".join(",".join(line) for line in lines) + "\n"
    for line in lines[1:]:
        value = float(line[i])
        changed = (line[j], value * 57.3, -value, 0.25, value * 1e6)[what]
        if what == 0:
            line[j] = line[i]
        line[i] = str(changed)
    return "\n".join(",".join(line) for line in lines) + "\n"


COMMON: tuple[Spoil, ...] = (
    _number,
    _number,
    _number,
    _cut,
    _lines,
    _letters,
    _encoded,
    _words,
    _nested,
)
XML: tuple[Spoil, ...] = (*COMMON, _elements, _elements, _tail, _tail, _mimic)
TABLE: tuple[Spoil, ...] = (*COMMON, _columns, _columns, _columns)
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
    commands = ("cross-check", "design", "identify", "feasible", "diagnose")
    command = rng.choices(commands, weights=(9, 4, 5, 1, 1))[0]
    with_data = command in ("identify", "feasible", "diagnose") or (
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
    else:
        name = rng.choices(list(ROBOTS), weights=(6, 2, 2, 2, 1))[0]
        files = {name: ROBOTS[name]}
    told = _spoil(files, folder, rng)
    file = f"{{in}}/{next(iter(files))}"
    source = ("{in}",) if with_data else (file,)
    if command == "design":
        source = ("--data" if with_data else "--robot", *source)
    more = rng.choices(
        [(), ("--joints", "joint_2"), ("--joints", "nobody"), ("--joints", "joint_1", "joint_1")],
        weights=(12, 2, 1, 1),
    )[0]
    if command == "cross-check":
        return Case(command, (*source, "--states", "50"), told)
    return Case(command, (*source, "--smoke", *(() if command == "diagnose" else more)), told)


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
