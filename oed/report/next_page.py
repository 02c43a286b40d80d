"""The page of the motion that tells apart what a diagnosis leaves open."""

from __future__ import annotations

from collections.abc import Mapping

from oed.diagnosis.discrimination.next_motion import NextExperiment
from oed.report.motion_charts import motion_charts
from oed.report.motion_recording import record_motion
from oed.report.page import Links, Page, Section, Text, Verdict
from oed.report.term_words import TermWords, in_words
from oed.robot import Robot

FILE = "trajectory.csv"
UNPROVEN = (
    "It was drawn within the limits of position, velocity and acceleration, without a proof; that the arm is clear "
    "of itself and of what stands around it was not looked at. It is periodic, and starts and ends at speed."
)


def next_page(following: NextExperiment, robot: Robot, words: Mapping[str, TermWords]) -> Page:
    """What the motion is for, how it looks, and what was assumed.

    Args:
        following: The motion.
        robot: The arm.
        words: For the labels of terms.
    """
    recorded = record_motion(robot, following.motion)
    moving = () if recorded.replay is None else (Section("The motion", (recorded.replay,)),)
    notes = [*following.notes, *([recorded.note] if recorded.note else [])]
    assumed = (Section("What is assumed", [Text(f"{note}.") for note in notes]),) if notes else ()
    pairs = "; ".join(in_words(pair, words) for pair in following.pairs)
    verdict = Verdict(
        "warning",
        f"To tell {pairs}.",
        f"The chance of naming the wrong one is {following.error_rate:.2%} after it, and "
        f"{following.error_rate_now:.2%} now. {UNPROVEN}",
    )
    return Page(
        "The next experiment",
        verdict,
        (
            *moving,
            Section("Joint by joint", motion_charts(robot, robot.limits, following.motion)),
            *assumed,
            Section("How to run it", [Links([(FILE, FILE, "set points of one period")])]),
        ),
    )
