"""What the log itself shows before any model: its rate and gaps, standstill, repetitions, noise."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.checkup.finding import EvidenceRow, Finding, share
from oed.checkup.suspicion import UNITS
from oed.counted import counted
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.fresh import fresh_samples
from oed.experiment.preparation.settings import ProcessingSettings
from oed.experiment.recording import Recording
from oed.experiment.signals.lowpass import lowpass
from oed.experiment.signals.resampling import resample, uniform_grid
from oed.experiment.stretches import gap_notes, gap_record, split_at_gaps

REPEATED_ROWS = 0.2  # of the rows: the state is read much faster than it is updated
STANDING_SPEED = 0.02  # [rad/s]; the speed over which a geared joint's friction turns
MOSTLY_STANDING = 0.5  # of the time, in which a joint tells nothing of its inertia
AT_LIMIT = 0.98  # of the effort limit, beyond which a drive is taken to be saturated
SATURATED = 0.01  # of the samples: fewer spoil no fit that weighs all alike; assumed


def rate_finding(dataset: DataSet, settings: ProcessingSettings) -> Finding:
    """Rate, jitter and gaps of each recording."""
    rows: list[EvidenceRow] = []
    for recording in dataset.recordings:
        steps = np.diff(recording.t)
        rows.append(
            {
                "recording": recording.name,
                "role": recording.role,
                "seconds": recording.duration,
                "rate [Hz]": 1 / float(np.median(steps)),
                "longest step [ms]": 1e3 * float(steps.max()),
                "repeated rows [%]": 100 * (1 - float(fresh_samples(recording).mean())),
            }
        )
    gaps = gap_notes(gap_record(dataset))
    repeated = max(float(str(row["repeated rows [%]"])) for row in rows) > 100 * REPEATED_ROWS
    told = [settings.reasons[0]] if settings.reasons else []
    told += list(gaps)
    if repeated:
        told.append("many rows repeat their predecessor: the log is read faster than it is updated")
    remedy = (
        "log without pauses, at the rate at which the controller updates"
        if gaps or repeated
        else ""
    )
    level = "amber" if gaps or repeated else "green"
    return Finding("rate and gaps", level, "; ".join(told), remedy, tuple(rows))


def standstill_finding(dataset: DataSet) -> Finding:
    """The share of time in which each joint stands."""
    joints = dataset.robot.joints
    shares = {
        role: _standing(group, np.array([joint.speed(STANDING_SPEED) for joint in joints]))
        for role, group in _by_role(dataset).items()
    }
    rows = tuple(
        {"joint": joint.name, **{f"{role} [%]": 100 * part[j] for role, part in shares.items()}}
        for j, joint in enumerate(joints)
    )
    of_estimation = shares.get("estimation", np.zeros(len(joints)))
    slow = np.flatnonzero(of_estimation > MOSTLY_STANDING)
    text = (
        f"share of the time below {STANDING_SPEED:g} rad/s, where the direction of friction is not "
        f"known: at most {100 * of_estimation.max():.0f} % in the recordings for estimation"
    )
    if dataset.still:
        still = ", ".join(
            f"{name} ({travel:.2g} rad or m)" for name, travel in dataset.still.items()
        )
        return Finding(
            "standstill",
            "red",
            f"does not move in the recordings for estimation: {still}; what is said of its friction "
            "and inertia is made of noise",
            "record it moving, or choose the other joints with --joints",
            rows,
        )
    if len(slow):
        names = ", ".join(joints[j].name for j in slow)
        return Finding("standstill", "amber", f"{text}; {names}", "record motion, not pauses", rows)
    return Finding("standstill", "green", text, "", rows)


def repetition_finding(dataset: DataSet) -> Finding:
    """Whether a motion was repeated, which tells noise from what the model lacks."""
    counts = {r.name: r.repetitions for r in dataset.recordings if r.repetitions > 1}
    if counts:
        told = ", ".join(f"{name} {count}" for name, count in counts.items())
        return Finding("repetitions", "green", f"repetitions of one motion: {told}")
    return Finding(
        "repetitions",
        "green",
        "no motion is repeated: noise cannot be told from what the model lacks, and the joints are "
        "weighted by their residuals",
        "play the motion five times or more and state repetitions and period in dataset.toml",
    )


def saturation_finding(dataset: DataSet) -> Finding:
    """The share of samples at the effort limit."""
    robot = dataset.robot
    limit = np.abs(robot.limits.torque).max(axis=1)
    limit = np.full(robot.n, np.inf) if robot.in_amperes else limit  # of torques
    tau = np.concatenate([recording.tau for recording in dataset.recordings])
    saturated = np.mean(np.abs(tau) >= AT_LIMIT * limit, axis=0)
    names = dataset.robot.joint_names
    rows = tuple(
        {
            "joint": names[j],
            f"largest torque [{dataset.torque_unit}]": float(np.abs(tau[:, j]).max()),
            "effort limit": float(limit[j]) if np.isfinite(limit[j]) else None,
            "at the limit [%]": 100 * float(saturated[j]),
        }
        for j in range(len(names))
    )
    bad = ", ".join(names[j] for j in np.flatnonzero(saturated > SATURATED))
    if bad:
        return Finding(
            "saturation",
            "amber",
            f"torque at the effort limit in more than {100 * SATURATED:g} % of the samples: {bad}; "
            "what the drive could not give is no dynamics",
            "slow the motion down until no drive saturates",
            rows,
        )
    factor = 1 / min(UNITS)  # of N m, of the largest unit that torques are logged in
    limited = np.isfinite(limit) & (tau != 0).any(axis=0)
    largest = np.abs(tau[:, limited]).max(axis=0)
    if limited.any() and (factor * largest <= limit[limited]).all():
        return Finding(
            "saturation",
            "amber",
            f"no torque is above 1/{factor:g} of the effort limit at any joint: they may be in "
            f"{UNITS[min(UNITS)]}",
            f"multiply the tau columns by {factor:g} if they are",
            rows,
        )
    return Finding("saturation", "green", "no drive is at its effort limit", "", rows)


def noise_finding(dataset: DataSet, settings: ProcessingSettings) -> Finding:
    """The usable band, and the torque's noise above it."""
    whole = split_at_gaps(dataset)
    above, torque = _noise_above(whole.estimation, settings)
    names = dataset.robot.joint_names
    ratio = np.divide(above, torque, out=np.zeros_like(above), where=torque > 0)
    rows = tuple(
        {
            "joint": name,
            f"torque in the band [{dataset.torque_unit}]": float(torque[j]),
            f"beyond the band [{dataset.torque_unit}]": float(above[j]),
            "ratio": float(ratio[j]),
        }
        for j, name in enumerate(names)
    )
    text = (
        f"motion lies below {settings.cutoff:g} Hz, where torque and model are low-passed; noise and "
        f"vibration above it are at most {share(float(ratio.max()))}, at {names[int(ratio.argmax())]}"
    )
    if ratio.max() > 1:
        remedy = "that joint hardly tells anything: move it more, or measure its torque more finely"
        return Finding("noise and usable band", "amber", text, remedy, rows)
    if settings.filtered_at is not None:
        text += (
            f"; the torque was filtered at about {settings.filtered_at:.3g} Hz before it was logged"
        )
        remedy = "log it unfiltered: friction's steps and the noise, which say how sure the estimate is, are beyond"
        return Finding("noise and usable band", "amber", text, remedy, rows)
    return Finding("noise and usable band", "green", text, "", rows)


def reader_finding(dataset: DataSet) -> Finding:
    """What the reader found doubtful about the numbers."""
    folders = {str(Path(r.source).parent) + "/" for r in dataset.recordings}
    notes = list(dataset.notes)
    for folder in folders:
        notes = [note.replace(folder, "") for note in notes]
    rows = tuple({"note": note} for note in notes)
    if not rows:
        return Finding("values", "green", "no value that a sensor can hardly have measured")
    text = f"{counted(len(rows), 'doubtful thing')} about the values, the first: {notes[0]}"
    return Finding("values", "amber", text, "", rows)


def _by_role(dataset: DataSet) -> dict[str, tuple[Recording, ...]]:
    groups = {
        "estimation": dataset.estimation,
        "validation": dataset.validation,
        "test": dataset.test,
    }
    return {role: group for role, group in groups.items() if group}


def _standing(
    recordings: tuple[Recording, ...], speed: Float[ndarray, " joints"]
) -> Float[ndarray, " joints"]:
    """Share of samples in which a joint is slower than a speed over a fifth of a second."""
    slow, count = np.zeros(len(speed)), 0
    for recording in recordings:
        stride = max(1, round(0.2 / float(np.median(np.diff(recording.t)))))
        if len(recording) <= stride:
            continue
        step = (recording.t[stride:] - recording.t[:-stride])[:, None]
        slow += np.sum(np.abs(recording.q[stride:] - recording.q[:-stride]) < speed * step, axis=0)
        count += len(recording) - stride
    return slow / max(count, 1)


def _noise_above(
    recordings: tuple[Recording, ...], settings: ProcessingSettings
) -> tuple[Float[ndarray, " joints"], Float[ndarray, " joints"]]:
    """Rms of the torque beyond the cut-off, and within it."""
    above, within = [], []
    for recording in recordings:
        grid = uniform_grid(recording.t, settings.rate)
        tau = resample(recording.t, recording.tau, grid)
        smooth = lowpass(tau, settings.rate, settings.cutoff)
        above.append(np.mean((tau - smooth) ** 2, axis=0))
        within.append(np.mean(smooth**2, axis=0))
    weights = [recording.duration for recording in recordings]
    beyond, inside = (np.sqrt(np.average(x, axis=0, weights=weights)) for x in (above, within))
    return beyond, inside
