"""How the logs of a data set are to be read: names of columns, units, signs, rate.

These are the keys `[columns]`, `[units]`, `sign`, `zero` and `rate` of `dataset.toml`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.counted import counted
from oed.experiment.toml_table import TomlTable
from oed.experiment.units import (
    CURRENTS,
    JOINT_QUANTITIES,
    KELVIN,
    TICKS,
    Quantity,
    factor_to_si,
    plain,
)
from oed.robot import Robot

TIME, REPETITION, TEMPERATURE = "t", "repetition", "temperature"
COLUMN_KEYS = (TIME, *JOINT_QUANTITIES, REPETITION, TEMPERATURE)
# Without which a recording is one all the same.
OPTIONAL: tuple[Quantity, ...] = ("dq", "ddq", TEMPERATURE)
UNIT_KEYS = (TIME, *JOINT_QUANTITIES, TEMPERATURE, "ticks_per_turn")
FORMAT_KEYS = ("columns", "units", "sign", "zero", "rate")
SI = {"t": "s", "q": "rad", "dq": "rad/s", "ddq": "rad/s^2", "tau": "N m", "temperature": "C"}


@dataclass(frozen=True)
class LogFormat:
    """How logs become SI numbers in the order of the joints.

    A position is sign x (logged - zero) in the unit that is stated, a velocity, an acceleration or a
    torque sign x logged.

    Attributes:
        columns: Names of the columns of each quantity, in the order of the joints; one name
            alone may stand for a column of lists. Empty: they are named as the format says.
        units: The unit of each quantity, one for all joints or one a joint; SI where none is given.
        ticks_per_turn: (n,) of encoders whose positions are in ticks.
        sign: (n,) +1 or -1 by quantity.
        zero: (n,) what is logged where the robot's joint is at zero, in the unit of the log.
        rate: Rows a second where no column tells the time [Hz].
    """

    columns: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    units: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    ticks_per_turn: Float[ndarray, " joints"] | None = None
    sign: Mapping[str, Float[ndarray, " joints"]] = field(default_factory=dict)
    zero: Float[ndarray, " joints"] | None = None
    rate: float | None = None

    def check(self, robot: Robot) -> None:
        """Raise `ValueError` if a unit is not one of the joint's quantity."""
        for quantity in JOINT_QUANTITIES:
            self.factors(quantity, robot)

    def with_units(self, units: Mapping[str, tuple[str, ...]]) -> LogFormat:
        """This format, with units of the quantities whose unit it does not say."""
        return dataclasses.replace(self, units={**units, **self.units})

    def unit(self, quantity: Quantity, joint: int = 0) -> str:
        """The unit that a quantity of a joint is logged in; "" where it is SI."""
        units = self.units.get(quantity, ("",))
        return units[joint if len(units) > 1 else 0]

    @property
    def is_current(self) -> bool:
        """Whether the unit of what stands for torque is one of currents."""
        return any(plain(unit) in CURRENTS for unit in self.units.get("tau", ()))

    def factors(self, quantity: Quantity, robot: Robot) -> Float[ndarray, " joints"]:
        """(n,) factors of a joint quantity to SI, signs included."""
        factors = np.ones(robot.n)
        for j, joint in enumerate(robot.joints):
            unit = self.unit(quantity, j)
            if unit:
                factors[j] = factor_to_si(quantity, unit, slides=joint.kind == "prismatic")
            if plain(unit).startswith(TICKS):
                if self.ticks_per_turn is None:
                    raise ValueError(f"{quantity} is in ticks: say how many ticks_per_turn")
                factors[j] /= self.ticks_per_turn[j]
        return factors * self.sign.get(quantity, 1.0)

    def to_si(
        self, quantity: Quantity, logged: Float[ndarray, "samples joints"], robot: Robot
    ) -> Float[ndarray, "samples joints"]:
        """(N, n) a joint quantity in SI, in the sense in which the robot counts."""
        offset = 0.0 if quantity != "q" or self.zero is None else self.zero
        factors = self.factors(quantity, robot)
        # Where there is nothing to convert, numbers stay as they are to the last bit.
        return (logged - offset) * factors if np.any(offset) or np.any(factors != 1) else logged

    def celsius(
        self, logged: Float[ndarray, "samples sensors"]
    ) -> Float[ndarray, "samples sensors"]:
        """(N, sensors) temperatures [degrees Celsius]."""
        return logged - KELVIN if plain(self.unit("temperature") or "C") == "K" else logged


def read_log_format(table: TomlTable, joints: int) -> LogFormat:
    """The format that a `dataset.toml` states."""
    columns, units = table.child("columns"), table.child("units")
    columns.only(*COLUMN_KEYS)
    units.only(*UNIT_KEYS)
    rate = table.number("rate") if table.has("rate") else None
    if rate is not None and not rate > 0:
        table.fail("rate", f"must be positive, got {rate:g} Hz")
    if rate is not None and columns.has(TIME):
        table.fail("rate", "stands beside a column of time; leave one of them out")
    ticks = None
    if units.has("ticks_per_turn"):
        ticks = units.number_each("ticks_per_turn", joints)
        if not (ticks > 0).all():
            units.fail("ticks_per_turn", "must be positive")
    return LogFormat(
        columns=_columns(columns, joints),
        units={key: _units(units, key, joints) for key in SI if units.has(key)},
        ticks_per_turn=ticks,
        sign=_signs(table, joints),
        zero=table.numbers("zero", joints) if table.has("zero") else None,
        rate=rate,
    )


def _columns(table: TomlTable, joints: int) -> dict[str, tuple[str, ...]]:
    """Names of columns by what they hold; no column holds two quantities."""
    columns = {key: _names(table, key, joints) for key in COLUMN_KEYS if table.has(key)}
    holds: dict[str, str] = {}
    for key, names in columns.items():
        for name in names:
            if name in holds:
                table.fail(key, f"names {name!r}, which is named for {holds[name]} already")
            holds[name] = key
    return columns


def _names(table: TomlTable, key: str, joints: int) -> tuple[str, ...]:
    value = table.value(key)
    # Columns of a file without a header are named by number.
    names = [
        str(item) if isinstance(item, int) else item
        for item in (value if isinstance(value, list) else [value])
    ]
    if not names or not all(isinstance(name, str) and name for name in names):
        table.fail(key, "must be the name of a column, or a list of names, one a joint")
    if len(set(names)) < len(names):
        table.fail(key, "names a column twice")
    if key in (TIME, REPETITION) and len(names) != 1:
        table.fail(key, "must be the name of one column")
    if key in JOINT_QUANTITIES and len(names) not in (1, joints):
        table.fail(key, f"has {counted(len(names), 'name')} for {counted(joints, 'joint')}")
    return tuple(map(str, names))


def _units(table: TomlTable, key: str, joints: int) -> tuple[str, ...]:
    value = table.value(key)
    if not isinstance(value, list):
        return (table.text(key),)
    if key not in JOINT_QUANTITIES:
        table.fail(key, "must be one unit in quotes")
    if len(value) != joints or not all(isinstance(unit, str) and unit for unit in value):
        table.fail(key, f"must be one unit in quotes, or a list of {joints}")
    return tuple(value)


def _signs(table: TomlTable, joints: int) -> dict[str, Float[ndarray, " joints"]]:
    """`sign = [1, -1]` of all that is logged of a joint, or `sign = {tau = [1, -1]}`."""
    if not table.has("sign"):
        return {}
    if isinstance(table.value("sign"), list):
        both = table.numbers("sign", joints)
        signs: dict[str, Float[ndarray, " joints"]] = dict.fromkeys(JOINT_QUANTITIES, both)
    else:
        child = table.child("sign")
        child.only(*JOINT_QUANTITIES)
        signs = {key: child.numbers(key, joints) for key in JOINT_QUANTITIES if child.has(key)}
    for values in signs.values():
        if not (np.abs(values) == 1).all():
            table.fail("sign", f"must be 1 or -1 for each joint, got {values.tolist()}")
    return signs
