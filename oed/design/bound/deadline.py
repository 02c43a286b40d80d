"""When a search gives up: a bound is worth having, not worth waiting for."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from oed.errors import OedError


class OutOfTime(OedError):
    """A deadline passed."""


@dataclass(frozen=True)
class Deadline:
    """A point in this process's CPU time and in wall time; loops ask whether it has passed.

    Attributes:
        cpu: Of `time.process_time` [s].
        wall: Of `time.monotonic` [s].
    """

    cpu: float = np.inf
    wall: float = np.inf

    @classmethod
    def after(cls, cpu_seconds: float, wall_seconds: float) -> Deadline:
        """So many seconds from now."""
        return cls(time.process_time() + cpu_seconds, time.monotonic() + wall_seconds)

    def check(self) -> None:
        """Go on, or not.

        Raises:
            OutOfTime: If it has passed.
        """
        if time.process_time() > self.cpu:
            raise OutOfTime("the CPU time set aside for it did not suffice")
        if time.monotonic() > self.wall:
            raise OutOfTime("other work of this machine left it too little time")


NEVER = Deadline()
