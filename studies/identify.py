"""What are this arm's dynamic parameters, and how far can they be trusted?

    python -m studies.identify --data DIR --out DIR …

The same as `oed identify DIR --out DIR …`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.commands.configurations import Identify
from oed.commands.identify import run
from oed.commands.options import parse
from oed.process_end import leave


@dataclass(frozen=True, kw_only=True)
class Config(Identify):
    """What are this arm's dynamic parameters, and how far can they be trusted?"""

    data: Path


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line."""
    return run(parse(Config, prog="python -m studies.identify", arguments=arguments))


if __name__ == "__main__":
    leave(main, "studies.identify")
