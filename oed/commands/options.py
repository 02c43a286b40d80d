"""How a command line becomes a frozen configuration: one way for every command and study.

The fields of the configuration are the options, their types what is accepted, their defaults the
defaults, and the attributes of its docstring the help (tyro reads them). What cannot be meant is
refused by `__post_init__`, with a ValueError that names the option.
"""

from __future__ import annotations

import io
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, redirect_stderr
from functools import partial
from pathlib import Path
from typing import Annotated, TypeVar

import tyro
from tyro.constructors import PrimitiveConstructorSpec

ConfigT = TypeVar("ConfigT")

# Nested settings are options like all others, a switch has no opposite, and what may be left out
# is left out.
STYLE = (
    tyro.conf.OmitArgPrefixes,
    tyro.conf.FlagCreatePairsOff,
    tyro.conf.DisallowNone,
)

HELP = {"-h", "--help"}
WIDE = "10000"  # [letters] more than a refused command line has


def parse(
    configuration: type[ConfigT],
    *,
    prog: str,
    arguments: Sequence[str] | None = None,
    description: str | None = None,
) -> ConfigT:
    """The configuration that a command line asks for.

    Args:
        configuration: A frozen dataclass.
        prog: How the command is called.
        arguments: What follows it; `sys.argv` if None.
        description: What help says first; the configuration's docstring if None.

    Raises:
        SystemExit: With 0 after `--help`; with 2 for options that cannot be used, which are told
            in one line.
    """
    with refused_in_one_line(prog, arguments):
        return tyro.cli(
            configuration, prog=prog, args=arguments, description=description, config=STYLE
        )


@contextmanager
def refused_in_one_line(prog: str, arguments: Sequence[str] | None = None) -> Iterator[None]:
    """What tyro says of options that cannot be used in a box is said in one line, as all errors.

    Args:
        prog: How the command is called.
        arguments: What follows it; `sys.argv` if None.
    """
    told = io.StringIO()
    is_help = not HELP.isdisjoint(sys.argv[1:] if arguments is None else arguments)
    try:
        with redirect_stderr(told), nullcontext() if is_help else _on_wide_terminal():
            yield
    except SystemExit as end:
        if end.code:
            from oed.errors import one_line  # noqa: PLC0415  # with numerical libraries

            sys.stderr.write(f"{prog}: {one_line(_unboxed(told.getvalue()))}; see {prog} --help\n")
        raise


@contextmanager
def _on_wide_terminal() -> Iterator[None]:
    """A box as wide as its text, in which no path is broken."""
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = WIDE
    try:
        yield
    finally:
        os.environ.pop("COLUMNS")
        if before is not None:
            os.environ["COLUMNS"] = before


def _unboxed(text: str) -> str:
    """What is said in a frame of lines, or of hyphens where the terminal has no letters for lines."""
    frame = r"[\u2500-\u257f]|^\s*-+\s*$"
    lines = [re.sub(frame, " ", line).strip() for line in text.splitlines()]
    told = " ".join(line for line in lines[1:] if line)
    told = re.split("For full helptext|Argument helptext", told)[0].strip()
    told, _, advice = told.partition(" Perhaps you meant: ")
    told = re.sub(r" or misplaced(?= options)| \(applied to [^)]*\)", "", told)
    told = told.partition(" Arguments are applied to")[0]
    told = re.sub(r"^Error parsing (?=--)|^Error parsing \w+: ", "", told)
    return f"{told}{_advised(told, advice)}"


def _advised(told: str, advice: str) -> str:
    """In a few words what tyro shows the help of: options of similar names, of other commands too."""
    # Each entry is an option, what it is for, and where.
    names = dict.fromkeys(re.findall(r"(?:^|--help )(--[\w-]+)", advice))
    if similar := [name for name in names if name not in told.split()]:
        return f"; perhaps you meant {' or '.join(similar)}"
    places = dict.fromkeys(re.findall(r"in (\w+ [\w-]+) --help", advice))
    return f"; an option of {', '.join(places)}" if places else ""


def _whole_number(text: Sequence[str], *, least: int) -> int:
    try:
        value = int(text[0])
    except ValueError:
        raise ValueError(f"{text[0]!r} is no whole number") from None
    if value < least:
        raise ValueError(f"{value} is no whole number from {least} on")
    return value


def _number_type(least: int) -> PrimitiveConstructorSpec[int]:
    return PrimitiveConstructorSpec(
        nargs=1,
        metavar="N",
        instance_from_str=partial(_whole_number, least=least),
        is_instance=lambda value: isinstance(value, int),
        str_from_instance=lambda value: [str(value)],
    )


def _existing_folder(text: Sequence[str]) -> Path:
    folder = Path(text[0])
    if not folder.is_dir():
        raise ValueError(f"{folder}: no such folder")
    return folder


def _named_folder(text: Sequence[str]) -> Path:
    # A path takes nothing for the folder at hand.
    if not text[0].strip():
        raise ValueError("is empty; name a folder")
    return Path(text[0])


def _folder_type(read: Callable[[Sequence[str]], Path]) -> PrimitiveConstructorSpec[Path]:
    return PrimitiveConstructorSpec(
        nargs=1,
        metavar="FOLDER",
        instance_from_str=read,
        is_instance=lambda value: isinstance(value, Path),
        str_from_instance=lambda value: [str(value)],
    )


# Of what there must be one at least.
Count = Annotated[int, _number_type(1)]
# Of random draws.
Seed = Annotated[int, _number_type(0)]
# A folder that is there.
Folder = Annotated[Path, _folder_type(_existing_folder)]
# A folder for results, which `oed.report.result_folder` judges.
OutFolder = Annotated[Path, _folder_type(_named_folder)]
