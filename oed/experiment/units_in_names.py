"""Units that names of columns state, as in `Torque 1 [Nm]`, `angle (deg)`, `time / s` or `q1_deg`."""

from __future__ import annotations

import re

from oed.experiment.units import JOINT_QUANTITIES, Quantity, plain, units_of

MARKED = (
    re.compile(r"^(.*\S)\s*[\[(]\s*([^\[\]()]+)\s*[\])]$"),
    re.compile(r"^(.*?\S)\s+/\s+(\S.*)$"),  # ISO 80000: a quantity over its unit
)
SUFFIXED = re.compile(r"^(.*)_(deg|rad|nm|mnm|a|ma|rpm|s|ms|us|ns|mm|m)$", re.IGNORECASE)
SPELLED = {"nm": "N m", "mnm": "mN m", "a": "A", "ma": "mA"}


def marked_unit(name: str, quantity: Quantity) -> tuple[str, str]:
    """A name without the unit in brackets or after a slash, and the unit; "" if it states none."""
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
    unit = _spelled(match[2])
    return (match[1], unit) if is_unit(unit, quantity) else (name, "")


def _spelled(unit: str) -> str:
    """Units of torque and current in the case that they have, which names often lack."""
    return SPELLED.get(unit.lower(), unit)


def is_unit(text: str, quantity: Quantity) -> bool:
    """Whether this is a unit of a quantity, of joints that turn or slide."""
    slides = (False, True) if quantity in JOINT_QUANTITIES else (False,)
    return any(plain(text) in units_of(quantity, slides=s) for s in slides)
