"""One data set of the bench, as words and numbers: all else follows from these."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Literal

import numpy as np

from studies.bench.forms import FORMS
from studies.bench.robots import ROBOTS

NoiseKind = Literal["white", "coloured", "felt"]


@dataclass(frozen=True)
class Case:
    """A data set to make and to judge.

    Attributes:
        group: What question it belongs to.
        robot: A key of `ROBOTS`.
        hidden: Keys of `FORMS`, none for a clean arm.
        size: Of the hidden effects; 1 is realistic.
        noise: "white" and "coloured" are of the torque signal; "felt" moves the arm.
        repeated: Whether every motion is repeated.
        seed: Of everything random.
    """

    group: str
    robot: str
    hidden: tuple[str, ...]
    size: float
    noise: NoiseKind
    repeated: bool
    seed: int

    def __post_init__(self) -> None:
        if self.robot not in ROBOTS:
            raise ValueError(f"no arm {self.robot!r}; there are {sorted(ROBOTS)}")
        unknown = [key for key in self.hidden if key not in FORMS]
        if unknown:
            raise ValueError(f"no forms {unknown}; there are {sorted(FORMS)}")

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        return (
            self.group,
            self.robot,
            "+".join(self.hidden),
            f"{self.size:g}",
            self.noise,
            "yes" if self.repeated else "no",
            str(self.seed),
        )

    def rng(self) -> np.random.Generator:
        """Source of everything random in this case."""
        return np.random.default_rng([self.seed, zlib.crc32("|".join(self.key).encode())])

    @property
    def label(self) -> str:
        """A folder name that says nothing of what is hidden."""
        return f"case-{zlib.crc32('|'.join(self.key).encode()):08x}"


KEY_COLUMNS = ("group", "robot", "hidden", "size", "noise", "repeated", "seed")
