"""Does this package compute the torque that Drake and Pinocchio compute? And how many base parameters?

    python -m studies.cross_check [--out DIR] [--smoke]

On the paper's SCARA and the arms of the package example-robot-data; `oed cross-check` takes any
robot file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from oed.commands.cross_check import NAMES, compare, tell, write
from oed.commands.options import Seed, parse
from oed.process_end import leave
from studies.data_folders import EXAMPLE_ARMS, EXAMPLE_ROBOTS
from studies.study_options import StudyOptions

STATES, FEW_STATES = 1000, 50


@dataclass(frozen=True)
class Options(StudyOptions):
    """Does this package compute the torque that Drake and Pinocchio compute?

    Attributes:
        seed: Of the random states.
    """

    study: ClassVar[str] = "cross_check"
    names: ClassVar[tuple[str, ...]] = NAMES

    seed: Seed = 0

    @property
    def robots(self) -> tuple[str, ...]:
        """The arms; two of them with --smoke."""
        arms = EXAMPLE_ARMS[1:2] if self.smoke else EXAMPLE_ARMS
        return ("builtin:imi_scara", *(str(EXAMPLE_ROBOTS / arm) for arm in arms))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 0 if all robots agree, 1 otherwise."""
    options = parse(Options, prog="python -m studies.cross_check", arguments=arguments)
    states = FEW_STATES if options.smoke else STATES
    with options.held() as results:
        rows = compare(options.robots, states, options.seed)
        with results.replaced() as new:
            write(rows, options, new, states, options.seed)
    return tell(rows)


if __name__ == "__main__":
    leave(main, "studies.cross_check")
