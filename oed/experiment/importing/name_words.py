"""What the words of a column's name tell beside the quantity: who says it, and that it is a joint's."""

from __future__ import annotations

import re
from typing import Literal

from oed.experiment.importing.quantity_names import (
    AT_THIS_INSTANT,
    OF_JOINTS,
    OF_MOTORS,
    OF_THE_ROBOT,
)

Source = Literal["measured", "commanded", "difference", "raw", "filtered", ""]

# Words of vendors and loggers. Actual, target: RTDE; cmd: libfranka; msr: the KUKA FRI; feedback,
# reference, desired, error: control_msgs; present, goal: Dynamixel; observation, action: LeRobot;
# ist, soll: German controllers; planned: ABB's EGM; demand: CiA 402; set: Beckhoff's SetPos.
SOURCES: dict[Source, frozenset[str]] = {
    "difference": frozenset({"error", "err"}),
    "commanded": frozenset({
        *("cmd", "command", "commanded", "target", "desired", "des", "reference", "ref", "setpoint"),
        *("goal", "action", "soll", "planned", "demand", "set"),
    }),
    "filtered": frozenset({"filtered", "filt", "smoothed", "smooth"}),
    "raw": frozenset({"raw", "unfiltered"}),
    "measured": frozenset({
        *("actual", "act", "measured", "measurement", "meas", "msr", "feedback", "fbk", "present"),
        *("observation", "observed", "sensed", "ist"),
    }),
}  # fmt: skip
# Words that say so only beside a word of a quantity, as in SetPos: a set of data is no set point.
ONLY_BESIDE_A_QUANTITY = frozenset({"set"})
FOLDER = re.compile(r"[^./]+")  # or what stands in it
SEPARATOR = r"[._/ -]+"
WORD = re.compile(r"[^\W\d_]+")
WORD_OR_NUMBER = re.compile(r"[^\W_]+")  # or both, as in arm2
# libfranka writes what is desired as q_d; beside the number of a joint that letter is no joint's name.
DESIRED = re.compile(r"(?<=[^\W_])_d(?=_?\d+$|\[)|(?<=\d)_d$")
BEFORE = re.compile(rf"({'|'.join((*OF_JOINTS, AT_THIS_INSTANT))}){SEPARATOR}", re.IGNORECASE)
NUMBERED = re.compile(rf"(?:{'|'.join(OF_JOINTS)}|j|a)?[._ -]?(?:(\d+)|\[(\d+)\])", re.IGNORECASE)


def without_source(name: str) -> tuple[str, Source, tuple[str, ...]]:
    """A name without the words that say whether it was measured, what they say, and these words.

    What was commanded is not measured, whatever it is the feedback of; the difference is neither.
    """
    name = DESIRED.sub("_desired", name)
    words = [word for part in FOLDER.findall(name) for word in _words_of_source(part)]
    if not words:
        return name, "", ()
    either = "|".join(map(re.escape, words))
    rest = re.sub(rf"\(\s*({either})\s*\)", r"\1", name)
    rest = re.sub(rf"(?<![^\W_])(?:{either}){SEPARATOR}", "", rest)
    rest = re.sub(rf"{SEPARATOR}(?:{either})(?![^\W\d_])", "", rest)
    said = {_source(word) for word in words}
    return rest, next(source for source in SOURCES if source in said), tuple(words)


def without_word_of_joints(name: str) -> tuple[str, str | None]:
    """The first word, and the name without it; no name if it does not say that it is of the joints."""
    match = BEFORE.match(name)
    return ("", None) if match is None else (match[1].lower(), name[match.end() :])


def is_of_motor(name: str) -> bool:
    """Whether a name says that it is of what turns a joint, ahead of the gear."""
    return any(word.lower() in OF_MOTORS for word in WORD.findall(name))


def joint_number(label: str) -> int | None:
    """The number of a joint that is told by no more than that, as in 3, J3 or joint_3."""
    match = NUMBERED.fullmatch(label)
    return None if match is None else int(match[1] or match[2])


def _words_of_source(part: str) -> list[str]:
    """The words of a folder's or a column's own name that say who says it."""
    words = WORD.findall(part)
    return [
        word
        for i, word in enumerate(words)
        if _source(word)
        and (
            word.lower() not in ONLY_BESIDE_A_QUANTITY
            or part == word
            or any(near.lower() in OF_THE_ROBOT for near in words[max(i - 1, 0) : i + 2])
        )
    ]


def _source(word: str) -> Source:
    """What a word says, in the singular or the plural."""
    lower = word.lower()
    for source, words in SOURCES.items():
        if lower in words or lower.removesuffix("s") in words:
            return source
    return ""
