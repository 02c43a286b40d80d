"""Ways to spoil a text file, each drawn at random."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

from tests.robot.test_description import TAIL

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
