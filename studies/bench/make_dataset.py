"""Make a data set of a case, with no trace of what is hidden, and the truth beside it."""

from __future__ import annotations

import copy
import dataclasses
import itertools
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording, Role
from oed.experiment.simulation import Log
from oed.experiment.write_dataset import write_dataset
from oed.robot import Robot
from studies.bench.arm import PERIOD, Arm
from studies.bench.case import Case
from studies.bench.excitation import random_fourier_motion
from studies.bench.forms import FORMS, Form
from studies.bench.laboratory import (
    LEAD_IN,
    Laboratory,
    Noise,
    build_laboratory,
    expected_torque,
)
from studies.bench.robots import ROBOTS
from studies.bench.truth import HiddenTruth, Truth, oracle_excess
from studies.bench.warmth import idle_warmth

RECORDINGS: tuple[tuple[str, Role], ...] = (
    ("estimation_1", "estimation"),
    ("estimation_2", "estimation"),
    ("validation", "validation"),
    ("test", "test"),
)
COLD_SHARE = 0.5  # of the cases where each recording begins with a cold arm


@dataclass(frozen=True)
class Hidden:
    """An arm with all effects of a case, what they are, and arms with one of them each."""

    arm: Arm
    truths: tuple[HiddenTruth, ...]
    alone: tuple[Arm, ...]


def make_dataset(case: Case, folder: Path) -> Truth:
    """Simulate a case and write its data set; nothing in the folder tells what is hidden.

    Args:
        case: What to make.
        folder: To create.

    Returns:
        The truth, for the judge alone.
    """
    rng = case.rng()
    bench = ROBOTS[case.robot]
    declared = bench.declared(folder.parent / f"{folder.name}-robot")
    duration = bench.period if case.repeated else bench.single
    references = [
        random_fourier_motion(declared.limits, duration, bench.highest, PERIOD, rng)
        for _ in RECORDINGS
    ]
    plain = bench.arm(declared, rng)
    plain = dataclasses.replace(plain, session=bool(rng.random() > COLD_SHARE))
    noise = Noise.draw(case.noise, bench.noise, rng)
    plain = dataclasses.replace(plain, peak=_peaks(plain, references))
    hidden = hide(case, plain, rng)
    measured = _with_thermometers(case, hidden.arm)
    laboratory = build_laboratory(measured, plain, noise, bench.decimation, rng)
    runs = bench.repetitions if case.repeated else 1
    recordings, logs = _record(laboratory, references, runs, rng)
    excess = oracle_excess(declared, hidden.arm, logs)
    alone = [
        tuple(_excess_alone(arm, plain, noise, references, runs).tolist())
        for arm in (hidden.alone if len(hidden.alone) > 1 else ())
    ]
    write_dataset(_dataset(case, declared, recordings), folder, file_format="parquet")
    return Truth(hidden.truths, noise.std, tuple(excess.tolist()), tuple(alone))


def hide(case: Case, arm: Arm, rng: np.random.Generator) -> Hidden:
    """Hide the effects of a case, each at a joint of its own where there are enough."""
    plain, truths, alone = arm, [], []
    taken: set[int] = set()
    for key in case.hidden:
        form = FORMS[key]
        joint = _draw_joint(form, arm.robot.n, taken, rng)
        alone.append(form.inject(plain, joint, case.size, copy.deepcopy(rng)).arm)
        injected = form.inject(arm, joint, case.size, rng)
        arm = injected.arm
        if not form.whole_arm:
            taken.add(joint)
        truths.append(
            HiddenTruth(
                form.name,
                form.key,
                form.kind,
                None if form.whole_arm else joint,
                dict(injected.parameters),
                injected.coordinates,
                dict(injected.in_catalogue),
            )
        )
    return Hidden(arm, tuple(truths), tuple(alone))


def _with_thermometers(case: Case, arm: Arm) -> Arm:
    """The arm with thermometers, if any, that show what hides nothing.

    Drawn apart from all else: older rounds stay the same but for these.
    """
    if arm.temperature is not None:
        return arm
    own = np.random.default_rng([case.seed, zlib.crc32(case.label.encode())])
    return dataclasses.replace(arm, temperature=idle_warmth(arm.robot.n, own))


def _draw_joint(form: Form, n: int, taken: set[int], rng: np.random.Generator) -> int:
    possible = range(form.first_joint, n - 1 if form.has_outer else n)
    free = [j for j in possible if j not in taken]
    return int(rng.choice(free or list(possible)))


def _record(
    laboratory: Laboratory, references: list[Motion], runs: int, rng: np.random.Generator
) -> tuple[list[Recording], list[tuple[Log, Float[ndarray, "rows joints"]]]]:
    """All recordings; and of those for estimation the log and the torque without noise."""
    recordings, logs = [], []
    undisturbed = dataclasses.replace(laboratory, decimation=1, noise=laboratory.noise.silent())
    starts = _starts(laboratory.arm, references, runs)
    for (name, role), reference, start in zip(RECORDINGS, references, starts, strict=True):
        log = laboratory.log(reference, rng, runs, start)
        recordings.append(laboratory.recording(log, rng, name=name, role=role)[0])
        if role == "estimation":
            if laboratory.noise.felt is not None:
                log = undisturbed.log(reference, rng, runs, start)
            logs.append((log, undisturbed.recording(log, rng, name=name, role=role)[1]))
    return recordings, logs


def _starts(arm: Arm, references: Sequence[Motion], runs: int) -> list[float]:
    """Time since the arm was cold at which each recording begins [s]."""
    if not arm.session:
        return [0.0 for _ in references]
    lengths = [runs * (LEAD_IN + len(reference) * PERIOD) for reference in references]
    return [0.0, *itertools.accumulate(lengths[:-1])]


def _excess_alone(
    arm: Arm, plain: Arm, noise: Noise, references: Sequence[Motion], runs: int
) -> Float[ndarray, " joints"]:
    """What one effect of several leaves unexplained where it is hidden alone, on the same motions."""
    rng = np.random.default_rng(0)  # of instruments that are read without noise
    laboratory = build_laboratory(arm, plain, noise.silent(), 1, rng)
    logs = []
    starts = _starts(arm, references, runs)
    for (name, role), reference, start in zip(RECORDINGS, references, starts, strict=True):
        if role == "estimation":
            log = laboratory.log(reference, rng, runs, start)
            logs.append((log, laboratory.recording(log, rng, name=name, role=role)[1]))
    return oracle_excess(plain.robot, arm, logs)


def _peaks(arm: Arm, references: list[Motion]) -> tuple[float, ...]:
    """Largest torque of each joint over the motions, as far as is known beforehand [N m]."""
    needed = np.concatenate([expected_torque(arm, reference[::20]) for reference in references])
    return tuple(np.abs(needed).max(axis=0).tolist())


def _dataset(case: Case, declared: Robot, recordings: list[Recording]) -> DataSet:
    return DataSet(
        name=case.label,
        source="simulated for the undeclared-effect bench",
        licence="CC0-1.0",
        robot=declared,
        torque="measured",
        recordings=tuple(recordings),
    )
