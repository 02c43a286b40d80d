"""Temperature of each joint along a recording."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.experiment.recording import Recording
from oed.experiment.signals.lowpass import lowpass
from oed.experiment.signals.resampling import resample

FASTEST = 0.2  # [Hz] that a housing or a winding follows; above it a thermometer shows its steps
LEAP = 10.0  # [K] from one row to the next, which no joint does
HOTTEST = 200.0  # [degrees Celsius] at which no motor runs any more
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
    uniform = resample(recording.t, measured, grid)
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
    measured: Float[ndarray, "samples sensors"],
    joints: int,
    file: str,
    lines: Int[ndarray, " samples"],
) -> Iterator[str]:
    """A line for each thing that is doubtful about temperatures.

    Args:
        measured: Temperatures [degrees Celsius].
        joints: Number of joints.
        file: For the message.
        lines: (N,) line of the file that each sample is of.
    """
    if not _are_known(measured, joints):
        fault = f"{measured.shape[1]} temperatures for {joints} joints do not say whose they are"
        yield f"{file}: {fault}: not used; log one for every joint, or one for all"
        return
    for k, shown in enumerate(measured.T):
        column, steps = f"column 'temperature_{k + 1}'", np.abs(np.diff(shown))
        if len(steps) and steps.max() > LEAP:
            row = int(np.argmax(steps)) + 1
            yield (
                f"{file}, row {lines[row]}, {column}: {shown[row]:.4g} after "
                f"{shown[row - 1]:.4g}: no joint warms so fast; repair the column, or leave it out"
            )
        if shown.max() > HOTTEST:
            yield (
                f"{file}, {column}: up to {shown.max():.4g}, taken for degrees Celsius; convert it "
                "if it is anything else"
            )


def _are_known(measured: Float[ndarray, "samples sensors"], joints: int) -> bool:
    """Whether their number tells whose thermometers are: one for each joint, or one for all."""
    return measured.shape[1] in (1, joints)
