"""The reference of the commands, made from the configurations that the commands themselves read."""

from __future__ import annotations

import re
from inspect import getdoc
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import tyro
from tyro.constructors import PrimitiveConstructorSpec

from oed.commands.configurations import Command
from oed.commands.main import COMMANDS
from oed.commands.option_fields import Option, options_of

WORDS = {int: "INT", float: "FLOAT", str: "STR", Path: "PATH", bool: ""}


def command_reference() -> str:
    """All commands, as Markdown."""
    return "\n\n".join(_command(name, kind) for name, (kind, _) in COMMANDS.items())


def _command(name: str, kind: type[Command]) -> str:
    words = re.sub(r"\n\n\s*Attributes:.*", "", getdoc(kind) or "", flags=re.DOTALL)
    options = sorted(options_of(kind), key=_is_option)
    usage = ["oed", name, *(value(o.type) for o in options if not _is_option(o)), "[options]"]
    table = ["| option | value | meaning | default |", "|---|---|---|---|", *map(_row, options)]
    return f"## `oed {name}`\n\n{words}\n\n```text\n{' '.join(usage)}\n```\n\n" + "\n".join(table)


def _is_option(option: Option) -> bool:
    """Whether it has a name on the command line, and not its place alone."""
    return tyro.conf.Positional not in getattr(option.type, "__metadata__", ())


def _row(option: Option) -> str:
    name = f"--{option.name.replace('_', '-')}" if _is_option(option) else option.name
    cells = (f"`{name}`", value(option.type), option.meaning, _default(option))
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def _default(option: Option) -> str:
    if option.is_required:
        return "**required**"
    if option.is_left_out:
        return ""
    several = option.default if isinstance(option.default, tuple) else (option.default,)
    return f"`{' '.join(map(str, several))}`"


def value(kind: Any) -> str:
    """What is written after an option of a type; nothing after a switch."""
    kinds = get_args(kind)
    if get_origin(kind) is Annotated:
        own = [x.metavar for x in kinds[1:] if isinstance(x, PrimitiveConstructorSpec)]
        return own[0] if own else value(kinds[0])
    if get_origin(kind) is Literal:
        return " or ".join(map(str, kinds))
    if get_origin(kind) in (Union, UnionType):
        return " or ".join(value(other) for other in kinds if other is not NoneType)
    if get_origin(kind) is tuple:
        return f"{value(kinds[0])} …" if kinds[1] is Ellipsis else " ".join(map(value, kinds))
    return WORDS[kind]
