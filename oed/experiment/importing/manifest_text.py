"""The text of a `dataset.toml` that was proposed: to be read, corrected and kept."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import tomli_w

LINE = 100  # letters
LIST = re.compile(r"^([\w.]+ = )\[\n((?:    [^\[\]\n]+,\n)+)\]", re.MULTILINE)

# Which notes stand above which table, by the word that a note begins with.
ABOVE = {
    "columns": ("t", "joints", "torque", "read", "taken", "unused"),
    "units": ("q", "dq", "tau"),
    "fixed": ("fixed",),
    "recording": ("roles",),
}


def manifest_text(content: Mapping[str, object], notes: Sequence[str]) -> str:
    """TOML with what was concluded as comments above each table.

    Args:
        content: Of the file.
        notes: What was concluded, a line each, such as "q: …".
    """
    plain = {key: value for key, value in content.items() if not _is_table(value)}
    tables = {key: value for key, value in content.items() if _is_table(value)}
    parts = [f"# Proposed from the log; correct what is wrong.\n{_dumped(plain)}"]
    told: set[str] = set()
    for key, value in tables.items():
        above = [note for note in notes if _word(note) in ABOVE.get(key, ())]
        told.update(above)
        comments = "".join(f"# {note}\n" for note in above)
        parts.append(comments + _table(key, value))
    left = "".join(f"# {note}\n" for note in notes if note not in told)
    return "\n".join(parts if not left else [parts[0], left, *parts[1:]])


def _table(key: str, value: object) -> str:
    """One table, or each of an array under its own header."""
    if isinstance(value, list):
        # The writer puts short ones on one line without a header, which the table before would own.
        return "\n".join(f"[[{key}]]\n{_dumped(entry)}" for entry in value)
    return _dumped({key: value})


def _dumped(content: Mapping[str, object]) -> str:
    """TOML with each list of numbers or words that fits into a line on one line."""
    return LIST.sub(_on_one_line, tomli_w.dumps(content))


def _on_one_line(match: re.Match[str]) -> str:
    items = [line.strip().rstrip(",") for line in match[2].strip().splitlines()]
    line = f"{match[1]}[{', '.join(items)}]"
    return line if len(line) <= LINE else match[0]


def _is_table(value: object) -> bool:
    return isinstance(value, dict) or (
        isinstance(value, list) and bool(value) and isinstance(value[0], dict)
    )


def _word(note: str) -> str:
    return note.replace(":", " ").split(" ", 1)[0]
