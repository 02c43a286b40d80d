"""Units that logs are written in, and their factors to SI."""

from __future__ import annotations

import re
from typing import Literal

import numpy as np

Quantity = Literal["t", "q", "dq", "ddq", "tau", "temperature"]
JOINT_QUANTITIES: tuple[Quantity, ...] = ("q", "dq", "ddq", "tau")

DEGREE = np.pi / 180  # [rad]
TURN = 2 * np.pi  # [rad]
TICKS = "ticks"  # of an encoder; how many make a turn is said beside it
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
ANGLES = {"rad": 1.0, "mrad": 1e-3, "deg": DEGREE, "turn": TURN}
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
TORQUES = {"Nm": 1.0, "mNm": 1e-3, "Nmm": 1e-3, "Ncm": 1e-2, "kNm": 1e3}
FORCES = {"N": 1.0, "mN": 1e-3, "kN": 1e3}
CURRENTS = {"A": 1.0, "mA": 1e-3}
TEMPERATURES = {"C": 1.0, "K": 1.0}
KELVIN = 273.15  # [K] at 0 degrees Celsius
# Other ways to write them, without blanks and signs of multiplication.
SYNONYMS = {
    "sec": "s", "second": "s", "seconds": "s", "msec": "ms", "usec": "us", "µs": "us", "μs": "us", "nsec": "ns",
    "radian": "rad", "radians": "rad", "degree": "deg", "degrees": "deg", "°": "deg", "rev": "turn", "turns": "turn",
    "grad": "deg", "grado": "deg", "gradi": "deg", "grados": "deg", "degré": "deg", "degrés": "deg",  # never gon
    "tick": TICKS, "counts": TICKS, "count": TICKS, "amp": "A", "ampere": "A",
    "1/min": "rpm", "min^-1": "rpm", "min-1": "rpm", "U/min": "rpm", "tr/min": "rpm", "giri/min": "rpm",
    "degC": "C", "°C": "C", "celsius": "C", "kelvin": "K", "r/min": "rpm", "rev/min": "rpm", "newtonmeter": "Nm",
}  # fmt: skip


def plain(unit: str) -> str:
    """A unit as this module writes it: "N m", "N·m" and "N*m" are "Nm", "rad/s²" is "rad/s^2"."""
    text = re.sub(r"[\s·*⋅]|(?<=N)\.(?=m)", "", unit).replace("²", "^2").replace("**2", "^2")
    base, slash, rate = text.partition("/")
    rate = {"sec": "s", "sec^2": "s^2", "s2": "s^2", "s/s": "s^2"}.get(rate, rate)
    return SYNONYMS.get(text, SYNONYMS.get(base, base) + slash + rate)


def units_of(quantity: Quantity, *, slides: bool = False) -> dict[str, float]:
    """The known units of a quantity and their factors to SI.

    Args:
        quantity: Of what.
        slides: Whether the joint is prismatic.

    Returns:
        Factors; that of `TICKS` is the turn that `ticks_per_turn` divides [rad].
    """
    if quantity == "t":
        return TIMES
    if quantity == "temperature":
        return TEMPERATURES
    if quantity == "tau":
        return (FORCES if slides else TORQUES) | CURRENTS
    lengths = LENGTHS if slides else ANGLES | {TICKS: TURN}
    if quantity == "q":
        return lengths
    suffix, power = ("/s", 1) if quantity == "dq" else ("/s^2", 2)
    found = {f"{name}{suffix}": factor for name, factor in lengths.items()}
    found |= {f"{name}/min": f / 60 for name, f in LENGTHS.items()} if slides and power == 1 else {}
    return found if slides or power == 2 else found | {"rpm": TURN / 60}


def factor_to_si(quantity: Quantity, unit: str, *, slides: bool = False) -> float:
    """What a number in this unit is multiplied by.

    Raises:
        ValueError: If the quantity has no such unit, naming those it has.
    """
    known = units_of(quantity, slides=slides)
    name = plain(unit)
    if name not in known:
        kind = "a prismatic joint" if slides else "a revolute joint"
        whose = f" of {kind}" if quantity in JOINT_QUANTITIES else ""
        raise ValueError(f"{unit!r} is no unit of {quantity}{whose}; known: {', '.join(known)}")
    return known[name]
