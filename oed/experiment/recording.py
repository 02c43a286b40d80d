"""One recording: joint positions and torques over time, as they were logged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

Role = Literal["estimation", "validation", "test"]
ROLES: tuple[Role, ...] = get_args(Role)
HELD_OUT: tuple[Role, ...] = ("validation", "test")
LEAST_TRAVEL = 1e-3  # [rad or m] of the joint that moves most: encoders read a tenth of it


@dataclass(frozen=True)
class Recording:
    """N samples of n joints, unfiltered.

    Attributes:
        name: Unique within its data set.
        role: What the recording may be used for.
        t: (N,) time, strictly increasing, not necessarily uniform [s].
        q: (N, n) joint position [rad or m].
        tau: (N, n) joint torque at the joint side [N m or N].
        dq: (N, n) logged joint velocity [rad/s or m/s].
        ddq: (N, n) logged joint acceleration [rad/s^2 or m/s^2].
        repetition: (N,) index of the repetition that each row belongs to.
        temperature: (N, sensors) temperature [degrees Celsius].
        period: Period of the motion [s].
        source: File that the recording was read from.
        unused_columns: Names of columns of that file that nothing here reads.
        notes: What is doubtful about its numbers, a line each, to be shown to the user.

    Raises:
        ValueError: If shapes disagree, a number is not finite, or time does not increase.
    """

    name: str
    role: Role
    t: Float[ndarray, " samples"]
    q: Float[ndarray, "samples joints"]
    tau: Float[ndarray, "samples joints"]
    dq: Float[ndarray, "samples joints"] | None = None
    ddq: Float[ndarray, "samples joints"] | None = None
    repetition: Int[ndarray, " samples"] | None = None
    temperature: Float[ndarray, "samples sensors"] | None = None
    period: float | None = None
    source: str = ""
    unused_columns: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.role not in ROLES:
            raise ValueError(f"role {self.role!r} is none of {ROLES}")
        self._check_shapes()
        for field in ("t", "q", "tau", "dq", "ddq", "temperature"):
            values = getattr(self, field)
            if values is not None and not np.isfinite(values).all():
                sample = int(np.argwhere(~np.isfinite(values))[0, 0])
                raise ValueError(f"{self.name}: {field} is not finite at sample {sample}")
        stuck = np.flatnonzero(np.diff(self.t) <= 0)
        if stuck.size:
            before, after = self.t[stuck[0] : stuck[0] + 2]
            raise ValueError(
                f"{self.name}: time does not increase at sample {stuck[0] + 1}: "
                f"{before:.16g} s is followed by {after:.16g} s"
            )
        if self.period is not None and not (np.isfinite(self.period) and self.period > 0):
            raise ValueError(f"{self.name}: a period of {self.period} s is not positive")

    def _check_shapes(self) -> None:
        if self.t.ndim != 1 or self.q.ndim != 2 or len(self.t) == 0 or self.q.shape[1] == 0:
            raise ValueError(f"{self.name}: t {self.t.shape} must be (N,), q {self.q.shape} (N, n)")
        if len(self.t) != len(self.q):
            raise ValueError(f"{self.name}: t has {len(self.t)} samples, q has {len(self.q)}")
        for field in ("tau", "dq", "ddq"):
            values = getattr(self, field)
            if values is not None and values.shape != self.q.shape:
                raise ValueError(f"{self.name}: {field} is {values.shape}, q is {self.q.shape}")
        for field in ("repetition", "temperature"):
            values = getattr(self, field)
            if values is not None and len(values) != len(self.t):
                raise ValueError(
                    f"{self.name}: {field} has {len(values)} samples, t has {len(self.t)}"
                )

    def __len__(self) -> int:
        return len(self.t)

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.q.shape[1]

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.t[-1] - self.t[0])

    @property
    def repetitions(self) -> int:
        """Number of repetitions that the recording is known to hold."""
        return 1 if self.repetition is None else len(np.unique(self.repetition))
