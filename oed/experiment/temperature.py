"""Temperature of each joint along a recording."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.experiment.recording import Recording
from oed.experiment.signals.lowpass import lowpass
from oed.experiment.signals.resampling import resample

FASTEST = 0.2  # [Hz] that a housing or a winding follows; above it a thermometer shows its steps
HIGHEST_SHARE = 0.2  # of the rate, for logs that are slower than that


def joint_temperature(
    recording: Recording, grid: Float[ndarray, " samples"]
) -> Float[ndarray, "samples joints"] | None:
    """What its thermometers say of each joint, smoothed [degrees Celsius].

    Args:
        recording: A thermometer for each joint, or one for all.
        grid: Instants at one rate [s].

    Returns:
        (N, n); None where there are no thermometers, or as many as tell not whose they are.
    """
    measured = recording.temperature
    if measured is None or not has_thermometers(recording):
        return None
    rate = 1 / float(np.median(np.diff(grid)))
    uniform = resample(recording.t, measured, grid, "linear")
    smooth = lowpass(uniform, rate, min(FASTEST, HIGHEST_SHARE * rate), order=1)
    return np.ascontiguousarray(np.broadcast_to(smooth, (len(grid), recording.n)))


def has_thermometers(recording: Recording) -> bool:
    """Whether it is known how warm each joint was."""
    measured = recording.temperature
    return measured is not None and _are_known(measured, recording.n)


def missing_notes(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Which recordings lack what others have, so that none is used."""
    lacking = [r.source or r.name for r in recordings if not has_thermometers(r)]
    if not lacking or len(lacking) == len(recordings):
        return ()
    return (
        f"temperatures of all joints are missing in {', '.join(lacking)}: not used elsewhere either",
    )


def temperature_of(
    recording: Recording, joints: Sequence[int]
) -> Float[ndarray, "samples sensors"] | None:
    """What the thermometers of some joints show; None where nothing says which these are."""
    measured = recording.temperature
    if measured is None or measured.shape[1] == 1:
        return measured
    return measured[:, joints] if measured.shape[1] == recording.n else None


def thermometer_notes(
    measured: Float[ndarray, "samples sensors"], joints: int, file: str
) -> tuple[str, ...]:
    """Why temperatures are of no use; none if they are.

    Args:
        measured: Temperatures.
        joints: Number of joints.
        file: Where they stand.
    """
    if _are_known(measured, joints):
        return ()
    fault = f"{measured.shape[1]} temperatures for {joints} joints do not say whose they are"
    return (f"{file}: {fault}: not used; log one for every joint, or one for all",)


def _are_known(measured: Float[ndarray, "samples sensors"], joints: int) -> bool:
    """Whether their number tells whose thermometers are: one for each joint, or one for all."""
    return measured.shape[1] in (1, joints)
