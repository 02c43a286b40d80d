"""What to do after a diagnosis that leaves something open: motions to record, and commands that exist."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.diagnosis.diagnose import Diagnosis
from oed.diagnosis.discrimination.next_motion import NextExperiment
from oed.report.diagnosis_record import NEXT
from oed.report.joint_words import place_words
from oed.report.term_words import in_words, words_of_terms
from oed.report.unnamed_terms import Unnamed, unnamed_terms

MODEL = "model.json"  # that a diagnosis leaves
SLOWER = 0.5  # of the speed: of a friction law two points, and a quarter of the inertial torque


@dataclass(frozen=True)
class Run:
    """Where a diagnosis was made, as its commands name it.

    Attributes:
        data: Folder of the data set.
        out: Folder of the results.
        budget: CPU time that the search was given [s]; None for no bound.
    """

    data: Path
    out: Path
    budget: float | None = None


@dataclass(frozen=True)
class Step:
    """One thing to do.

    Attributes:
        text: What, and what it shows.
        commands: Lines for a terminal.
    """

    text: str
    commands: tuple[str, ...] = ()


def next_steps(found: Diagnosis, following: NextExperiment | None, run: Run) -> tuple[Step, ...]:
    """What to do next, most telling first; nothing where nothing is open.

    Args:
        found: The diagnosis.
        following: The motion that tells apart what is open, if one was designed.
        run: Where it was made.
    """
    if found.verdict not in ("ambiguous", "unexplained"):
        return ()
    unnamed = unnamed_terms(found)
    return (
        *_telling_apart(found, following),
        *_further(unnamed, run),
        *_nearest_names(unnamed),
        *_motions(unnamed, run),
        *_alone(found, unnamed, run),
        *_over_time(found, unnamed),
        *_disturbed(found),
        *_repetitions(found),
        *_own_effect(unnamed),
        Step(
            "Add every new log to the data set, as a [[recording]] of dataset.toml with its file, a name and "
            'role = "estimation", and diagnose again.',
            (_line("diagnose", str(run.data), "--out", "again/"),),
        ),
    )


def _line(*words: str) -> str:
    return shlex.join(("oed", *words))


def _telling_apart(found: Diagnosis, following: NextExperiment | None) -> tuple[Step, ...]:
    """For names that are open."""
    words = words_of_terms(found)
    if following is not None:
        pairs = "; ".join(in_words(pair, words) for pair in following.pairs)
        return (
            Step(f"Run {NEXT}/trajectory.csv on the arm and log it: it was made to tell {pairs}."),
        )
    open_names = [e for e in found.effects if e.is_open]
    return tuple(
        Step(
            f"Whether it is {e.name} ({place_words(e.joint)}) is open, and no motion was found to tell. "
            f"It is exposed by: {e.page.exposed_by}."
        )
        for e in open_names
    )


def _nearest_names(unnamed: Sequence[Unnamed]) -> tuple[Step, ...]:
    """What would show the name that comes nearest."""
    places: dict[tuple[str, str], list[str]] = {}
    for u in unnamed:
        if u.nearest is not None:
            key = u.nearest.entry.name, u.nearest.entry.page.exposed_by
            places.setdefault(key, []).append(place_words(u.joint))
    return tuple(
        Step(
            f"The nearest name at {_listed(joints)} is {name}. What exposes it, by the catalogue: "
            f"{exposed_by}."
        )
        for (name, exposed_by), joints in places.items()
    )


def _motions(unnamed: Sequence[Unnamed], run: Run) -> tuple[Step, ...]:
    """Another motion at two speeds, unless all that is left goes with time alone."""
    if all(set(u.depends_on) == {"time"} for u in unnamed):
        return ()
    base = ("design", "--data", str(run.data), "--seed", "1")
    return (
        Step(
            "Record a new motion at full and at half speed, along one path: what depends on position "
            "alone stays the same there, what depends on speed or acceleration changes. Another --seed "
            "gives another path.",
            (
                _line(*base, "--out", "motion/"),
                _line(*base, "--scale", str(SLOWER), "--out", "slower/"),
            ),
        ),
    )


def _alone(found: Diagnosis, unnamed: Sequence[Unnamed], run: Run) -> tuple[Step, ...]:
    """One joint alone, where another may be the cause; joints of a robot without a file cannot be left out."""
    robot = found.before.model.robot
    if robot.description is None or robot.n == 1:
        return ()
    doubtful = dict.fromkeys(
        u.joint for u in unnamed if not u.depends_on or _other_joints(u.depends_on, u.joint)
    )
    if not doubtful:
        return ()
    each = "each of joints" if len(doubtful) > 1 else "joint"
    return (
        Step(
            f"Record a motion of {each} {_listed(str(j + 1) for j in doubtful)} alone: what is gone there "
            "comes from the motion of the others, what is left does not.",
            tuple(
                _line(
                    *("design", "--data", str(run.data), "--joints", robot.joint_names[j]),
                    *("--out", f"alone_{j + 1}/"),
                )
                for j in doubtful
            ),
        ),
    )


def _other_joints(coordinates: Sequence[str], joint: int) -> bool:
    numbers = {name.rpartition("_")[2] for name in coordinates if name != "time"}
    return bool(numbers - {str(joint + 1)})


def _disturbed(found: Diagnosis) -> tuple[Step, ...]:
    """What tells where a disturbance comes from, once for those that are told alike."""
    joints: dict[str, dict[str, None]] = {}
    for d in found.disturbances:
        joints.setdefault(d.exposed_by, {})[place_words(d.joint)] = None
    return tuple(
        Step(f"To know what is left at {_listed(places)}, {exposed_by}.")
        for exposed_by, places in joints.items()
    )


def _over_time(found: Diagnosis, unnamed: Sequence[Unnamed]) -> tuple[Step, ...]:
    disturbed = {d.joint for d in found.disturbances}
    joints = dict.fromkeys(
        place_words(u.joint) for u in unnamed if "time" in u.depends_on and u.joint not in disturbed
    )
    if not joints:
        return ()
    return (
        Step(
            f"What is left at {_listed(joints)} changes with time: record one motion cold and warm, and log "
            "the drive's temperature, as a column temperature_1 and so on."
        ),
    )


def _repetitions(found: Diagnosis) -> tuple[Step, ...]:
    if found.noise_source == "repetitions":
        return ()
    return (
        Step(
            "Run each motion several times in a row, and write repetitions = 6 and period = 10.0 (times, and "
            "seconds each) in its [[recording]] of dataset.toml: noise is then what differs between runs. "
            f"Nothing was repeated here: the noise floor is what a {found.noise_source} leaves, and may hide or hold part of what is left."
        ),
    )


def _further(unnamed: Sequence[Unnamed], run: Run) -> tuple[Step, ...]:
    """More of the same search: without its bound, or from where it ended."""
    steps = []
    if run.budget is not None:
        steps.append(
            Step(
                f"This search was given {run.budget:g} s of CPU time; without that bound it may find more.",
                (_line("diagnose", str(run.data), "--out", "longer/"),),
            )
        )
    joints = dict.fromkeys(place_words(u.joint) for u in unnamed if not u.depends_on)
    if joints:
        steps.append(
            Step(
                f"What is left at {_listed(joints)} follows no curve that was tried: look once more, "
                "from the model that was found.",
                (
                    _line(
                        *("diagnose", str(run.data), "--model", str(run.out / MODEL)),
                        *("--out", "second/"),
                    ),
                ),
            )
        )
    return tuple(steps)


def _own_effect(unnamed: Sequence[Unnamed]) -> tuple[Step, ...]:
    if not unnamed:
        return ()
    return (
        Step(
            "If you know a cause that the catalogue lacks, write its formula as an effect of your own, "
            "with oed.dynamics.effects.catalogue.named_effect: it is then weighed like the others."
        ),
    )


def _listed(words: Iterable[str]) -> str:
    *others, last = words
    return f"{', '.join(others)} and {last}" if others else last
