"""From a robot's file to an excitation motion that provably keeps its limits.

    python -m studies.design --robot FILE|builtin:NAME --out DIR …

The same as `oed design`.
"""

from __future__ import annotations

from collections.abc import Sequence

from oed.commands.configurations import Design
from oed.commands.design import run
from oed.commands.options import parse
from oed.process_end import leave


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line."""
    return run(parse(Design, prog="python -m studies.design", arguments=arguments))


if __name__ == "__main__":
    leave(main, "studies.design")
