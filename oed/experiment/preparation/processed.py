"""The rows of a prepared recording that an estimate is made of: a piece for each stretch without a gap."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.experiment.preparation.band import Band
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.recording import Role

Evaluate = Callable[[Motion], Float[ndarray, "fine joints columns"]]
WHOLE = slice(None)
PIECE = 20_000  # fine samples that a model is evaluated on at once: memory that a computer spares


@dataclass(frozen=True, eq=False)
class ProcessedRecording:
    """Motion and torque of one stretch of a recording, in one frequency band.

    Attributes:
        name: Of the recording.
        role: Of the recording.
        motion: N rows.
        tau: (N, n) torque in the band [N m or N].
        certainty: (N, n) share of noise in the variance of each row's error; the rest is friction of
            no known direction.
        fine: The motion that the model is evaluated on, at the log's own rate.
        fine_tau: The torque there, before it is filtered [N m or N].
        band: Filter and decimation from the one to the other.
        repetition: (N,) repetition that each row belongs to, where the recording says.
    """

    name: str
    role: Role
    motion: Motion
    tau: Float[ndarray, "samples joints"]
    certainty: Float[ndarray, "samples joints"]
    fine: Motion = field(repr=False)
    fine_tau: Float[ndarray, "fine joints"] = field(repr=False)
    band: Band = field(repr=False)
    repetition: Int[ndarray, " samples"] | None = None

    def __post_init__(self) -> None:
        if self.tau.shape != self.motion.q.shape or self.certainty.shape != self.tau.shape:
            raise ValueError(f"tau is {self.tau.shape}, q is {self.motion.q.shape}")

    def __len__(self) -> int:
        return len(self.tau)

    @property
    def rate(self) -> float:
        """Of the rows [Hz]."""
        return self.band.analysis_rate

    @property
    def bandwidth(self) -> float:
        """Cut-off of the band [Hz]: successive residuals are correlated over about 1 / (2 bandwidth)."""
        return self.band.cutoff

    def columns(
        self, evaluate: Evaluate, *, remembers: bool = True, rows: slice = WHOLE
    ) -> Float[ndarray, "samples joints columns"]:
        """A model's columns in the band of `tau`, at its rows.

        Args:
            evaluate: The columns at every instant of a motion.
            remembers: Whether an instant's depend on those before it: then all are evaluated at once.
            rows: Those that are wanted.
        """
        found: Float[ndarray, "samples joints columns"] | None = None
        wanted = range(len(self))[rows]
        for place, piece in self.pieces(evaluate, remembers=remembers, rows=rows):
            if found is None:
                found = np.empty((len(wanted), *piece.shape[1:]))
            found[place.start - wanted.start : place.stop - wanted.start] = piece
        if found is None:
            raise ValueError(f"{self.name}: there are no rows")
        return found

    def pieces(
        self, evaluate: Evaluate, *, remembers: bool = True, rows: slice = WHOLE
    ) -> Iterator[tuple[slice, Float[ndarray, "samples joints columns"]]]:
        """The same a stretch of rows at a time, each with its place: memory does not grow with them.

        Where an instant's columns depend on those before, the wanted rows are one stretch.
        """
        wanted = range(len(self))[rows]
        if remembers and len(wanted):
            whole = self._columns_between(evaluate, 0, len(self))
            yield slice(wanted.start, wanted.stop), whole[wanted.start : wanted.stop]
            return
        step = max(1, PIECE // self.band.factor)
        for begin, end in _stretches(wanted.start, wanted.stop, step):
            yield slice(begin, end), self._columns_between(evaluate, begin, end)

    def _columns_between(
        self, evaluate: Evaluate, first: int, last: int
    ) -> Float[ndarray, "samples joints columns"]:
        fine = self._filtered_from(first, last)
        # A sample more on both sides: the mean sign over a step asks for its neighbours.
        wider = slice(max(fine.start - 1, 0), fine.stop + 1)
        seen = evaluate(self.fine[wider])[fine.start - wider.start :][: fine.stop - fine.start]
        found = np.empty((last - first, *seen.shape[1:]))
        for j in range(seen.shape[1]):  # the filter wants each joint's columns side by side
            found[:, j] = self.band.apply(np.ascontiguousarray(seen[:, j]))
        return found

    def _filtered_from(self, first: int, last: int) -> slice:
        """The fine samples that these rows are filtered from."""
        factor = self.band.factor
        return slice(first * factor, (last - 1) * factor + len(self.band.taps))


def _stretches(first: int, last: int, step: int) -> Iterator[tuple[int, int]]:
    for begin in range(first, last, step):
        yield begin, min(begin + step, last)


def processed(
    prepared: Prepared, certainty: Float[ndarray, "valid_rows joints"] | None = None
) -> tuple[ProcessedRecording, ...]:
    """The rows of a recording whose whole filter window was recorded, a piece for each stretch.

    Args:
        prepared: The recording.
        certainty: Of its valid rows; one if None.
    """
    edges = np.flatnonzero(np.diff(prepared.valid, prepend=False, append=False))
    stretches = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
    found, done = [], 0
    for number, (first, last) in enumerate(stretches, 1):
        name = prepared.name if len(stretches) == 1 else f"{prepared.name}, stretch {number}"
        own = None if certainty is None else certainty[done : done + last - first]
        found.append(_stretch(prepared, name, first, last, own))
        done += last - first
    return tuple(found)


def _stretch(
    prepared: Prepared,
    name: str,
    first: int,
    last: int,
    certainty: Float[ndarray, "samples joints"] | None,
) -> ProcessedRecording:
    band = prepared.band
    fine = slice(first * band.factor, (last - 1) * band.factor + len(band.taps))
    motion, tau = prepared.motion[fine], prepared.torque[first:last]
    settled = slice(band.reach, len(motion) - band.reach, band.factor)
    return ProcessedRecording(
        name=name,
        role=prepared.role,
        motion=dataclasses.replace(motion[settled], averaged=False),
        tau=tau,
        certainty=np.ones_like(tau) if certainty is None else certainty,
        fine=motion,
        fine_tau=prepared.fine_torque[fine],
        band=band,
        repetition=prepared.repetition[first:last] if prepared.period is not None else None,
    )
