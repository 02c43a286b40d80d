"""The reference of the commands, made from the configurations that the commands themselves read."""

from __future__ import annotations

import re
import warnings
from argparse import Action, ArgumentParser
from inspect import getdoc
from typing import Any

import tyro

from oed.commands.configurations import Command
from oed.commands.main import COMMANDS
from oed.commands.options import STYLE

DEFAULT = re.compile(r"\s*\((?:default: (?P<value>[^()]*)|required|optional)\)\s*$", re.DOTALL)


def command_reference() -> str:
    """All commands, as Markdown."""
    return "\n\n".join(_command(name, kind) for name, (kind, _) in COMMANDS.items())


def _command(name: str, kind: type[Command]) -> str:
    parser = parser_of(name, kind)
    words = re.sub(r"\n\n\s*Attributes:.*", "", getdoc(kind) or "", flags=re.DOTALL)
    positional = [action for action in parser._actions if not action.option_strings]  # noqa: SLF001  # argparse has no public list
    options = [action for action in parser._actions if action.option_strings]  # noqa: SLF001  # likewise
    usage = " ".join(["oed", name, *(_metavar(action) for action in positional), "[options]"])
    rows = [_row(action) for action in (*positional, *options) if action.dest != "help"]
    table = "\n".join(["| option | value | meaning | default |", "|---|---|---|---|", *rows])
    return f"## `oed {name}`\n\n{words}\n\n```text\n{usage}\n```\n\n{table}"


def parser_of(name: str, kind: type[Command]) -> ArgumentParser:
    """The parser of one command, as `oed NAME --help` shows it."""
    with warnings.catch_warnings():
        # tyro announces the end of this function without another that lists the options.
        warnings.simplefilter("ignore", DeprecationWarning)
        # Its own copy of argparse, of the same shape.
        parser: Any = tyro.extras.get_parser(kind, prog=f"oed {name}", config=STYLE)
        return parser


def _row(action: Action) -> str:
    text = " ".join((action.help or "").split())
    found = DEFAULT.search(text)
    meaning = text if found is None else text[: found.start()]
    default = "" if found is None else _default(found["value"], text)
    option = ", ".join(f"`{word}`" for word in action.option_strings) or f"`{action.dest}`"
    value = _escaped(_metavar(action)) if action.nargs != 0 else ""
    return f"| {option} | {value} | {_escaped(meaning)} | {default} |"


def _default(value: str | None, text: str) -> str:
    if value is None:
        return "**required**" if text.endswith("(required)") else ""
    return "" if value.strip() in ("", "''", "None", "False") else f"`{value.strip()}`"


def _metavar(action: Action) -> str:
    metavar = action.metavar if isinstance(action.metavar, str) else action.dest.upper()
    several = re.match(r"\[*\{?([^\[\]{}]+?)\}? \[", metavar)
    return f"{_choices(several[1])} …" if several else _choices(metavar)


def _choices(metavar: str) -> str:
    return metavar.strip("{}").replace(",", " or ")


def _escaped(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;")
