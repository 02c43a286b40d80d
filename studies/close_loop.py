"""What does the torque model lack, what is it, and what does adding it gain?

    python -m studies.close_loop --data DIR --out DIR …

The same as `oed diagnose DIR --out DIR …`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.commands.configurations import Diagnose
from oed.commands.diagnose import run
from oed.commands.options import parse
from oed.process_end import leave


@dataclass(frozen=True, kw_only=True)
class Config(Diagnose):
    """What does the torque model lack, what is it, and what does adding it gain?"""

    data: Path


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line."""
    return run(parse(Config, prog="python -m studies.close_loop", arguments=arguments))


if __name__ == "__main__":
    leave(main, "studies.close_loop")
