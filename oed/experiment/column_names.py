"""Which columns of a log are which quantity."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import get_args

from oed.counted import MOST_SHOWN, counted
from oed.errors import DataSetError
from oed.experiment.log_format import REPETITION, SI, TEMPERATURE, TIME, LogFormat
from oed.experiment.logs.table import Log, Table
from oed.experiment.toml_table import nearest
from oed.experiment.units import JOINT_QUANTITIES, Quantity, units_of
from oed.experiment.units_in_names import marked_unit, unknown_unit
from oed.robot import Robot

NUMBERED = re.compile(r"(q|dq|ddq|tau)_(\d+)")
SENSOR = re.compile(r"temperature_(\d+)")
REQUIRED = ("q", "tau")


@dataclass(frozen=True)
class ColumnNames:
    """The columns found in one table, by field of `Recording`, each in the order of the joints.

    Attributes:
        table: That holds them.
        fields: Names by quantity; "t" is not among them where the rows have a rate.
    """

    table: Table
    fields: dict[str, tuple[str, ...]]

    @property
    def units(self) -> dict[str, tuple[str, ...]]:
        """Units that the names themselves state, as in `q_1 [deg]`, by quantity; "" is none."""
        found = {
            quantity: tuple(marked_unit(name, quantity)[1] for name in self.fields[quantity])
            for quantity in get_args(Quantity)
            if quantity in self.fields
        }
        return {quantity: units for quantity, units in found.items() if any(units)}

    @property
    def all(self) -> tuple[str, ...]:
        """Every column found."""
        return tuple(name for names in self.fields.values() for name in names)

    def logged_as(self, column: str) -> str:
        """The log's name for a column such as "q_2"."""
        quantity, _, number = column.rpartition("_")
        names = self.fields.get(quantity or number, ())
        index = int(number) - 1 if quantity and number.isdigit() else 0
        return names[index] if index < len(names) else column


def find_columns(log: Log, robot: Robot, log_format: LogFormat) -> ColumnNames:
    """Assign the columns of a log to the fields of a recording.

    Raises:
        DataSetError: If a column is missing, there are columns for another number of joints, or names
            end with a unit that is not known where none is stated.
    """
    found = [ColumnNames(table, _fields(table, robot, log_format)) for table in log.tables]
    missing = [[name for name in one.all if name not in one.table.columns] for one in found]
    best = min(range(len(found)), key=lambda i: len(missing[i]))
    if missing[best]:
        raise _missing(found[best], missing[best][0], log_format)
    _check_units(found[best], log_format)
    return found[best]


def joint_columns(quantity: str, joints: int) -> tuple[str, ...]:
    """The names quantity_1 … quantity_n."""
    return tuple(f"{quantity}_{i + 1}" for i in range(joints))


def _fields(table: Table, robot: Robot, log_format: LogFormat) -> dict[str, tuple[str, ...]]:
    stated = log_format.columns
    if not stated:
        _check_joint_count(table, robot)
    fields: dict[str, tuple[str, ...]] = {}
    if log_format.rate is None:
        fields[TIME] = stated.get(TIME) or _as_logged(table, (TIME,), TIME)
    for quantity in JOINT_QUANTITIES:
        usual = _as_logged(table, _usual_names(table, quantity, robot), quantity)
        if quantity in stated:
            fields[quantity] = _elements(table, stated[quantity], robot)
        elif quantity in REQUIRED or (not stated and any(name in table.columns for name in usual)):
            fields[quantity] = usual
    if REPETITION in stated or (not stated and REPETITION in table.columns):
        fields[REPETITION] = stated.get(REPETITION, (REPETITION,))
    sensors = sum(bool(SENSOR.fullmatch(name)) for name in table.columns)
    if TEMPERATURE in stated or (not stated and sensors):
        fields[TEMPERATURE] = stated.get(TEMPERATURE) or joint_columns(TEMPERATURE, sensors)
    return fields


def _check_units(found: ColumnNames, log_format: LogFormat) -> None:
    for quantity in JOINT_QUANTITIES:
        names = found.fields.get(quantity, ())
        unit = "" if quantity in log_format.units else unknown_unit(names, quantity)
        if unit:
            message = (
                f"{unit!r} is none of the units of {quantity} that are known "
                f"({', '.join(units_of(quantity))}): convert the columns and name them without it, or, if "
                f"it is no unit, say what they are in, as in --units {quantity}={SI[quantity].replace(' ', '')} "
                "of oed import"
            )
            raise DataSetError(message, file=found.table.file, column=names[0])


def _usual_names(table: Table, quantity: Quantity, robot: Robot) -> tuple[str, ...]:
    """Columns q_1 … q_n, or named by joint, as in q_shoulder, where there is one such."""
    numbered = joint_columns(quantity, robot.n)
    named = tuple(f"{quantity}_{joint}" for joint in robot.joint_names)
    present = {*table.columns, *(marked_unit(name, quantity)[0] for name in table.columns)}
    return named if not present & {*numbered} and present & {*named} else numbered


def _as_logged(table: Table, names: tuple[str, ...], quantity: Quantity) -> tuple[str, ...]:
    """Names with the unit that a log writes behind them, where it does."""
    logged = {bare: name for name in table.columns for bare in (marked_unit(name, quantity)[0],)}
    return tuple(name if name in table.columns else logged.get(name, name) for name in names)


def _elements(table: Table, names: tuple[str, ...], robot: Robot) -> tuple[str, ...]:
    """The names as they are, or the n elements of the one column of lists that is named."""
    name, *more = names
    if not more and name in table.columns and robot.n > 1:
        raise DataSetError(
            f"is one joint's: [columns] of dataset.toml must name {robot.n} such, one a joint",
            file=table.file,
            column=name,
        )
    if more or name in table.columns:
        return names
    elements = table.elements(name)
    if elements and len(elements) != robot.n:
        joints = counted(robot.n, "joint")
        message = f"holds lists of {len(elements)}, for {joints}; name its elements instead"
        raise DataSetError(message, file=table.file, column=name)
    return elements or names


def _missing(found: ColumnNames, name: str, log_format: LogFormat) -> DataSetError:
    table = found.table
    others = [other for other in table.columns if other not in found.all]
    if not log_format.columns and all(column.isdigit() for column in table.columns):
        message = (
            "holds numbers and no names of columns; add a header line such as "
            "t,q_1,q_2,tau_1,tau_2 above them, or name columns by number in [columns] of "
            "dataset.toml, such as t = 1, q = [2, 3]"
        )
        return DataSetError(message, file=table.file, row=table.first_row)
    hint = f"; {nearest(name, others[:MOST_SHOWN])}" if others else ""
    close = nearest(name, others) if others else ""
    if close.startswith("did you mean"):
        hint = f"; {close.partition('?')[0]}?"
    who = "[columns] of dataset.toml names it" if log_format.columns else "the header must name it"
    message = f"missing; {who}{hint}"
    return DataSetError(message, file=table.file, row=table.header_row, column=name)


def _check_joint_count(table: Table, robot: Robot) -> None:
    for name in table.columns:
        match = NUMBERED.fullmatch(name)
        if match is None or match[2] in robot.joint_names:
            continue
        digits = match[2]
        if digits.startswith("0"):
            message = "columns are numbered 1, 2, … without leading zeros"
            raise DataSetError(message, file=table.file, row=table.header_row, column=name)
        if len(digits) > 6 or int(digits) > robot.n:
            message = (
                f"this column is of joint {digits[:12]}, but `joints` in dataset.toml lists "
                f"{robot.n}; name the missing joints there or remove the column"
            )
            raise DataSetError(message, file=table.file, row=table.header_row, column=name)
