"""Units that names of columns state, as in `Torque 1 [Nm]`, `angle (deg)`, `time / s` or `q1_deg`."""

from __future__ import annotations

import re
from collections.abc import Sequence

from oed.experiment.units import JOINT_QUANTITIES, Quantity, plain, units_of

MARKED = (
    re.compile(r"^(.*\S)\s*[\[(]\s*([^\[\]()]+)\s*[\])]$"),
    re.compile(r"^(.*?\S)\s+/\s+(\S.*)$"),  # ISO 80000: a quantity over its unit
    re.compile(r"^(.*\S)[\s_]+in[\s_]+(\S.*)$"),
)
# Names of variables have no slash: rad_s, radps and rad_per_s are rad/s. An "m" at the end is as often
# said of a motor, or of what was measured, and adds nothing where it is metres.
SUFFIXED = re.compile(
    r"^(.*?[^_])_(deg|rad|grad|grados|gradi|nm|mnm|a|ma|rpm|s|ms|us|ns|mm|ticks|counts"
    r"|(?:deg|rad|grad|mm|m|ticks|counts)(?:ps|_s|_?per_?s(?:ec)?)(?:2|ps|_2)?)$",
    re.IGNORECASE,
)
OVER = re.compile(r"(ps|_s|_?per_?s(?:ec)?)(2|ps|_2)?$", re.IGNORECASE)
SPELLED = {"nm": "N m", "n.m": "N m", "mnm": "mN m", "a": "A", "ma": "mA"}


def marked_unit(name: str, quantity: Quantity) -> tuple[str, str]:
    """A name without the unit in brackets, after a slash or after "in", and the unit; "" if it states none."""
    for pattern in MARKED:
        match = pattern.fullmatch(name.strip())
        if match is not None and is_unit(_spelled(match[2]), quantity):
            return match[1], _spelled(match[2])
    return name, ""


def suffixed_unit(name: str, quantity: Quantity) -> tuple[str, str]:
    """The same for a unit after an underscore, which may as well be the name of a joint."""
    match = SUFFIXED.fullmatch(name.strip())
    if match is None:
        return name, ""
    over = OVER.sub(lambda rate: "/s^2" if rate[2] else "/s", match[2])
    unit = _spelled(over if "/" in over[1:] else match[2])
    return (match[1], unit) if is_unit(unit, quantity) else (name, "")


def unknown_unit(names: Sequence[str], quantity: Quantity) -> str:
    """What the names of a quantity of several joints all end with in brackets, if it is no unit of it.

    What differs from one to the next is of which joint it is, and a word of four letters or more is
    more likely one of the name: units are shorter, or hold a sign.
    """
    matches = [MARKED[0].fullmatch(name.strip()) for name in names]
    marks = {"" if match is None else match[2] for match in matches}
    mark = marks.pop() if len(marks) == 1 < len(names) else ""
    return "" if re.fullmatch(r"[\w\s]{4,}", mark) or is_unit(_spelled(mark), quantity) else mark


def _spelled(unit: str) -> str:
    """The unit in the case that it has, which names often lack."""
    lower = unit.lower()
    known = SPELLED.get(lower)
    return known or (plain(lower) if re.match("deg|rad|grad", lower) else unit)


def is_unit(text: str, quantity: Quantity) -> bool:
    """Whether this is a unit of a quantity, of joints that turn or slide."""
    slides = (False, True) if quantity in JOINT_QUANTITIES else (False,)
    return any(plain(text) in units_of(quantity, slides=s) for s in slides)
