"""How a command line becomes a frozen configuration: one way for every command and study.

The fields of the configuration are the options, their types what is accepted, their defaults the
defaults, and the attributes of its docstring the help (see `oed.commands.option_fields`). What cannot be meant is
refused by `__post_init__`, with a ValueError that names the option.
"""

from __future__ import annotations

import io
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, redirect_stderr
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, TypeVar, get_args, get_type_hints

import tyro
from tyro.constructors import PrimitiveConstructorSpec

from oed.commands.option_fields import REGISTRY
from oed.largest_number import LARGEST, MOST_GRAVITY

ConfigT = TypeVar("ConfigT")

# Nested settings are options like all others, a switch has no opposite, and what may be left out
# is left out.
STYLE = (
    tyro.conf.OmitArgPrefixes,
    tyro.conf.FlagCreatePairsOff,
    tyro.conf.DisallowNone,
)

# What tyro and Python say of what cannot be read, and what is said of it here.
IN_WORDS = (
    (r"^Error parsing (?=--)|^Error parsing \w+: ", ""),
    (r"'None', |, 'None'", ""),
    (
        r"invalid choice (.+) for argument '(--[\w-]+)'\. Expected one of \((.*?)\)\.",
        r"\2: \1 is none of \3",
    ),
    (r"invalid literal for int\(\) with base 10: (.+)", r"\1 is no whole number"),
    (r"no type matching .* from \[(.*?)\]\. Got errors: .*", r"cannot be read: \1"),
    (r"Could not find valid parse for arguments: \[(.*)\]", r"cannot be read: \1"),
    (r"could not convert string to float: (.+)", r"\1 is no number"),
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
            configuration,
            prog=prog,
            args=arguments,
            description=description,
            config=STYLE,
            registry=REGISTRY,
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
    for words, plain in IN_WORDS:
        told = re.sub(words, plain, told)
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
    value = int(text[0])
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


@dataclass(frozen=True)
class Range:
    """Which numbers an option can mean, for `check_ranges`.

    Attributes:
        least: In the option's unit.
        most: Likewise.
        is_open: Whether `least` is too little itself.
    """

    least: float = -LARGEST
    most: float = LARGEST
    is_open: bool = False

    def __contains__(self, value: int | float) -> bool:
        return self.least <= value <= self.most and not (self.is_open and value == self.least)

    def __str__(self) -> str:
        start = f"above {self.least:g}, up" if self.is_open else f"from {self.least:g}"
        return f"{start} to {self.most:g}"


def check_ranges(configuration: object) -> None:
    """Refuse numbers that a field's type, such as `Positive`, does not hold.

    tyro would say what is wrong with one of several values in its own terms.

    Args:
        configuration: A dataclass.

    Raises:
        ValueError: Naming the option.
    """
    for name, hint in get_type_hints(type(configuration), include_extras=True).items():
        given = getattr(configuration, name)
        for value in given if isinstance(given, tuple) else (given,):
            for allowed in _ranges(hint):
                if isinstance(value, (int, float)) and value not in allowed:
                    option = name.replace("_", "-")
                    shown = f"{value:g}" if isinstance(value, float) else str(value)
                    raise ValueError(f"--{option} {shown} is no number {allowed}")


def _ranges(hint: object) -> set[Range]:
    """All in a type, within a union or tuple too."""
    own = {x for x in getattr(hint, "__metadata__", ()) if isinstance(x, Range)}
    return own.union(*(_ranges(inner) for inner in get_args(hint)))


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
Whole = Annotated[int, Range(0.0)]
Real = Annotated[float, Range()]
Positive = Annotated[float, Range(0.0, is_open=True)]
NotNegative = Annotated[float, Range(0.0)]
# Of an arm or what it holds [kg]: from a gram on.
Mass = Annotated[float, Range(1e-3, 1e6)]
# Of a place on an arm or near it [m].
Place = Annotated[float, Range(-100.0, 100.0)]
# Of a component of gravity [m/s^2].
Gravity = Annotated[float, Range(-MOST_GRAVITY, MOST_GRAVITY)]
# Of rows of a log, or at which a controller or a simulation asks for torque [Hz]: from what a hand
# can follow to ten times a drive's own current loop.
Rate = Annotated[float, Range(1.0, 1e6)]
# Of something, of which a thousandth is as good as nothing.
Share = Annotated[float, Range(1e-3, 1.0)]
# A folder that is there.
Folder = Annotated[Path, _folder_type(_existing_folder)]
# A folder for results, which `oed.report.result_folder` judges.
OutFolder = Annotated[Path, _folder_type(_named_folder)]
