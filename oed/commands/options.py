"""How a command line becomes a frozen configuration: one way for every command and study.

The fields of the configuration are the options, their types what is accepted, their defaults the
defaults, and the attributes of its docstring the help (tyro reads them). What cannot be meant is
refused by `__post_init__`, with a ValueError that names the option.
"""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr
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
    with refused_in_one_line(prog):
        return tyro.cli(
            configuration, prog=prog, args=arguments, description=description, config=STYLE
        )


@contextmanager
def refused_in_one_line(prog: str) -> Iterator[None]:
    """What tyro says of options that cannot be used in a box is said in one line, as all errors.

    Args:
        prog: How the command is called.
    """
    told = io.StringIO()
    try:
        with redirect_stderr(told):
            yield
    except SystemExit as end:
        if end.code:
            sys.stderr.write(f"{prog}: {_unboxed(told.getvalue())}; see {prog} --help\n")
        raise


def _unboxed(text: str) -> str:
    lines = [re.sub("[\u2500-\u257f]", " ", line).strip() for line in text.splitlines()]
    told = " ".join(line for line in lines[1:] if line)
    told = re.split("For full helptext|Argument helptext", told)[0].strip()
    return re.sub(r"^Error parsing (?=--)|^Error parsing \w+: ", "", told)


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
