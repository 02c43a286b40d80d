"""The command `oed`."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Sequence
from functools import partial
from typing import Never

import tyro

from oed import __version__
from oed.commands import configurations
from oed.commands.option_fields import REGISTRY
from oed.commands.options import STYLE, refused_in_one_line
from oed.process_end import (
    BAD_INPUT,
    NOTHING,
    STEPS,
    end_quietly_while_loading,
    exit_status,
    unread_output,
)

# Name: configuration, and the module whose `run` takes it, loaded when it is asked for.
COMMANDS: dict[str, tuple[type[configurations.Command], str]] = {
    "import": (configurations.ImportLog, "import_log"),
    "check": (configurations.Check, "check"),
    "design": (configurations.Design, "design"),
    "identify": (configurations.Identify, "identify"),
    "feasible": (configurations.Feasible, "feasible"),
    "payload": (configurations.Payload, "payload"),
    "gains": (configurations.Gains, "gains"),
    "diagnose": (configurations.Diagnose, "diagnose"),
    "calibrate": (configurations.Calibrate, "calibrate"),
    "export": (configurations.Export, "export"),
    "demo": (configurations.Demo, "demo"),
    "cross-check": (configurations.CrossCheck, "cross_check"),
}
IN_STEPS = ("calibrate", "demo")  # each step leaves a folder of its own
DESCRIPTION = """From a robot file and a log to a dynamic model that you can trust.

Exit status: 0 done; 1 something disagrees; 2 the input cannot be used; 3 the input is in order, and
what was asked for cannot be had; 130 interrupted.

oed --version says which one this is; oed --tyro-write-completion {bash,zsh,fish} FILE writes what a
shell completes command lines by."""
COMPLETION = ("--tyro-write-completion", "--tyro-print-completion")


def main() -> Never:
    """Run the command that the process was given, and end it with the command's status."""
    end_quietly_while_loading("oed")
    with unread_output():  # of `oed --help | head` too
        sys.exit(run(sys.argv[1:] or ["--help"]))


def run(arguments: Sequence[str]) -> int:
    """Run one command: its exit status.

    Args:
        arguments: Name of the command, and what it is told.

    Raises:
        SystemExit: With 0 after `--help`, with 2 for options that cannot be used.
    """
    if list(arguments) == ["--version"]:
        print(f"oed {__version__}")
        return 0
    config = configuration_of(arguments)
    name, module = next((n, m) for n, (kind, m) in COMMANDS.items() if type(config) is kind)
    # Before `exit_status` turns an interrupt into an error, which compiled modules that are being
    # loaded turn into others.
    command = importlib.import_module(f"oed.commands.{module}").run
    told = STEPS if name in IN_STEPS else NOTHING
    return exit_status(partial(_run, command, config), f"oed {name}", told)


def _run(command: Callable[[configurations.Command], int], config: configurations.Command) -> int:
    # `--help` has nothing to show, and no use for numerical libraries.
    from oed.one_thread import on_one_thread  # noqa: PLC0415
    from oed.report.progress import shown  # noqa: PLC0415

    with shown(quiet=config.quiet):
        # Only now are all libraries loaded of which each has threads of its own.
        return on_one_thread(command)(config)


def configuration_of(arguments: Sequence[str]) -> configurations.Command:
    """What a command line asks for.

    Args:
        arguments: Name of the command, and what it is told.

    Raises:
        SystemExit: With 0 after `--help`, with 2 for options that cannot be used.
    """
    try:
        return _configuration_of(arguments)
    except (AssertionError, ImportError, OSError) as error:  # as tyro ends without such a shell
        if not arguments or arguments[0] not in COMPLETION:
            raise
        sys.stderr.write(f"oed: {arguments[0]}: {error}; name bash, zsh or fish, and a file\n")
        raise SystemExit(BAD_INPUT) from error


def _configuration_of(arguments: Sequence[str]) -> configurations.Command:
    named = bool(arguments) and arguments[0] in COMMANDS
    with refused_in_one_line(f"oed {arguments[0]}" if named else "oed", arguments):
        return tyro.extras.subcommand_cli_from_dict(
            {name: configuration for name, (configuration, _) in COMMANDS.items()},
            prog="oed",
            description=DESCRIPTION,
            args=arguments,
            config=STYLE,
            registry=REGISTRY,
        )


if __name__ == "__main__":
    main()
