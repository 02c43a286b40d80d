"""Xacro: a URDF with macros, expanded by the xacro package in a process with bounds."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from oed.errors import RobotError

SECONDS = 60  # of CPU and of waiting; expanding a humanoid takes two
# In an element of a link or joint: a value that only xacro can tell.
EXPRESSION = re.compile(r"\$[{(]")
RAISED = re.compile(r"^[A-Za-z_.]*(Error|Exception)\b:? ?")
HINT = (
    "a xacro file is read with the defaults of its arguments, or with those that follow its name, "
    "as in 'arm.urdf.xacro name:=left'"
)


def is_xacro(root: ElementTree.Element) -> bool:
    """Whether a URDF's tree holds macros or expressions that are yet to be expanded."""
    for element in root.iter():
        if isinstance(element.tag, str) and "/xacro}" in element.tag:
            return True
    return any(
        EXPRESSION.search(value)
        for kind in ("link", "joint")
        for owner in root.findall(kind)
        for element in owner.iter()
        for value in element.attrib.values()
    )


def expand_xacro(path: Path, arguments: Sequence[str] = ()) -> bytes:
    """The URDF that a xacro file expands to.

    Args:
        path: The file.
        arguments: NAME:=VALUE each, for the arguments of the file.

    Raises:
        RobotError: If it cannot be expanded.
    """
    # -I: no folder of the user's is searched for modules.
    child = Path(__file__).with_name("xacro_child.py")
    mappings = dict(argument.split(":=", 1) for argument in arguments)
    request = {"path": str(path), "seconds": SECONDS, "mappings": mappings}
    try:
        done = subprocess.run(  # noqa: S603  # our own program, without a shell
            [sys.executable, "-I", str(child)],
            input=json.dumps(request).encode(),
            capture_output=True,
            timeout=SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise RobotError(
            f"{path}: this is xacro, and expanding it takes more than {SECONDS} s"
        ) from error
    if done.returncode:
        raise RobotError(
            f"{path}: this is xacro, which cannot be expanded: {_reason(done, path)}; {HINT}"
        )
    return done.stdout


def _reason(done: subprocess.CompletedProcess[bytes], path: Path) -> str:
    if done.returncode < 0:
        return f"it takes too much time or memory (more than {SECONDS} s or 2 GB)"
    text = re.sub(r"\x1b\[[0-9;]*m", "", done.stderr.decode(errors="replace"))
    lines = [line.strip() for line in text.replace(str(path), path.name).splitlines()]
    # The last exception, and what it says in the lines after its name.
    starts = [i for i, line in enumerate(lines) if RAISED.match(line)]
    told = lines[starts[-1] :] if starts else lines[:4]
    reason = " ".join(RAISED.sub("", line) for line in told if line)
    if any(line.startswith("MemoryError") for line in lines):
        return "it takes more than 2 GB of memory"
    return reason or "xacro says nothing of the reason"
