"""Which columns of a log are time, positions and torques, and of which joints."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from oed.counted import as_one, listed
from oed.errors import DataSetError
from oed.experiment.drive import TorqueKind
from oed.experiment.importing.assign_joints import RobotJoints, assign_joints, places
from oed.experiment.importing.column_groups import listed_columns
from oed.experiment.importing.layouts import MEASURED, Named, columns_of, torques_of, whose
from oed.experiment.importing.quantity_names import STEMS, TORQUES
from oed.experiment.importing.taken import of_same_joints, taken_notes
from oed.experiment.log_format import OPTIONAL, REPETITION
from oed.experiment.logs.table import Log, Table
from oed.experiment.units import CURRENTS, Quantity, plain
from oed.experiment.units_in_names import marked_unit

RELATIVE = re.compile(r"[%‰]|\bper ?cent\b", re.IGNORECASE)


@dataclass(frozen=True)
class ColumnProposal:
    """Columns of a log by quantity, in the order of `joints`.

    Attributes:
        table: That holds them.
        joints: Names in the robot's file.
        columns: Names by quantity.
        units: Units that the names state, by quantity.
        torque: What the torque seems to be.
        notes: Why, a line each.
        log: That the table is of.
    """

    table: Table
    joints: tuple[str, ...]
    columns: Mapping[str, tuple[str, ...]]
    units: Mapping[str, tuple[str, ...]]
    torque: TorqueKind
    notes: tuple[str, ...]
    log: Log


def propose_columns(
    log: Log, joints: RobotJoints, stated: Mapping[str, tuple[str, ...]]
) -> ColumnProposal:
    """Find the columns of a log.

    Args:
        log: With one table or several.
        joints: Of the robot.
        stated: Columns that the user named, which are taken as they are; an empty tuple
            leaves a quantity out.

    Raises:
        DataSetError: If there is no time, position or torque, saying what there is and what to do.
    """
    errors = []
    for table in log.tables:
        try:
            return _proposal(log, table, joints, stated)
        except DataSetError as error:
            errors.append(error)
    # The first table has the most columns.
    raise errors[0]


def _proposal(
    log: Log, table: Table, joints: RobotJoints, stated: Mapping[str, tuple[str, ...]]
) -> ColumnProposal:
    called = {column: _called(table, column) for column in table.columns}
    stated = {key: _elements(table, names) for key, names in stated.items()}
    if not stated and all(column.isdigit() for column in table.columns):
        message = (
            f"its {len(table.columns)} columns have no names; say which is what by number, as in "
            "--columns t=1 q=2,3 tau=4,5"
        )
        raise DataSetError(message, file=table.file, row=table.first_row)
    order, names = _positions(table, called, joints, _stated(stated, "q"))
    chosen: dict[Quantity, list[Named]] = {} if "q" in stated else {"q": order}
    columns, units = {"q": tuple(one.column for one in order)}, {"q": _units(order)}
    for quantity in OPTIONAL:
        found = of_same_joints(columns_of(called, STEMS[quantity], quantity), order)
        chosen |= {} if quantity in stated else {quantity: found}
        found = _stated(stated, quantity) if quantity in stated else found
        if found:
            columns[quantity], units[quantity] = tuple(o.column for o in found), _units(found)
    torque, kind, more = _torque(table, called, order, stated)
    chosen |= {} if stated.get("tau") else {"tau": torque}
    _check_not_relative(torque, table)
    columns["tau"], units["tau"] = tuple(one.column for one in torque), _units(torque)
    times = (_times(called, stated) or _points_in_time(table))[:1]
    if times:
        columns["t"], units["t"] = (times[0].column,), _units(times)
    if REPETITION in table.columns:
        columns[REPETITION] = (REPETITION,)
    given = {key: value for key, value in units.items() if any(value)}
    notes = (*table.text, _told(order, names), *more, *taken_notes(called, chosen))
    return ColumnProposal(table, names, columns, given, kind, notes, log)


def _times(called: Mapping[str, str], stated: Mapping[str, tuple[str, ...]]) -> list[Named]:
    """Columns of time, one of the whole log before one within a folder of it."""
    if "t" in stated:
        return _stated(stated, "t")
    found = [one for named in columns_of(called, STEMS["t"], "t") for one in named]
    found.sort(key=lambda one: re.search(r"\bT\b", one.column) is not None)  # or a temperature
    within = [
        one for one in found if re.fullmatch(rf".*[./]{re.escape(one.stem)}", one.column.lower())
    ]
    return [one for one in found if not one.label] or within


def _points_in_time(table: Table) -> list[Named]:
    """The column that can only be the time, by what it holds."""
    return [Named(name, "", "", "") for name in table.times] if len(table.times) == 1 else []


def _called(table: Table, column: str) -> str:
    return table.labels.get(column, column.removeprefix(f"{table.name}.") if table.name else column)


def _elements(table: Table, names: Sequence[str]) -> tuple[str, ...]:
    """Names of columns, with those of the elements in place of a column of lists."""
    return tuple(
        each
        for name in names
        for each in (() if name in table.columns else table.elements(name)) or (name,)
    )


def _stated(stated: Mapping[str, tuple[str, ...]], quantity: str) -> list[Named]:
    names = stated.get(quantity, ())
    return [Named(name, "", str(i + 1), "", whose=whose(name)) for i, name in enumerate(names)]


def _positions(
    table: Table, called: Mapping[str, str], joints: RobotJoints, stated: list[Named]
) -> tuple[list[Named], tuple[str, ...]]:
    """Positions in the order of the robot's joints, and the names of these.

    Of the columns that may be positions, those of the first stem that is of the robot's joints; a
    stem with a column for each of several joints goes before one that has a single one.
    """
    found = [stated] if stated else columns_of(called, STEMS["q"], "q")
    # Of a log with plain names, others are of something else, such as of the tool.
    found = [named for named in found if named[0].is_plain == found[0][0].is_plain]
    errors = []
    for named in [named for named in found if len(named) > 1] or found[:1]:
        try:
            order, names = assign_joints(named, joints, table)
            return (_as_labelled(order, called) if stated else order), names
        except DataSetError as error:
            errors.append(error)
    if errors:
        raise errors[0]
    commanded = columns_of(called, STEMS["q"], "q", ("commanded",))
    if commanded:
        names = [one.column for one in commanded[0]]
        message = (
            f"holds positions that were commanded ({as_one(names)}) and none that were measured; to take "
            "those, name them, as in --columns q=NAME,NAME"
        )
        raise DataSetError(message, file=table.file)
    raise DataSetError(_nothing(table, "joint positions", "q"), file=table.file)


def _as_labelled(stated: Sequence[Named], called: Mapping[str, str]) -> list[Named]:
    """Positions that the user named, with the joints that their own names tell, where all do."""
    for named in columns_of(called, STEMS["q"], "q", (*MEASURED, "commanded")):
        labels = {one.column: one.label for one in named}
        own = [labels[one.column] for one in stated if one.column in labels]
        if len(own) == len(set(own)) == len(stated):
            return [replace(one, label=label) for one, label in zip(stated, own, strict=True)]
    return list(stated)


def _torque(
    table: Table,
    called: Mapping[str, str],
    order: Sequence[Named],
    stated: Mapping[str, tuple[str, ...]],
) -> tuple[list[Named], TorqueKind, list[str]]:
    if stated.get("tau"):
        return _stated(stated, "tau"), _kind_of_stated(called, stated["tau"]), []
    for kind in TORQUES:
        found = of_same_joints(torques_of(called, kind), order)
        if found:
            # A torque in amperes is a current.
            in_amperes = kind == "measured" and all(plain(one.unit) in CURRENTS for one in found)
            own: TorqueKind = "current" if in_amperes else kind
            return found, own, [_about(own, found)]
    message = _nothing(table, "torque (effort, current) of every joint", "tau")
    elsewhere = [
        place
        for kind in TORQUES
        for named in torques_of(called, kind)
        for place in places([one for one in named if one.whose != order[0].whose])
    ]
    if elsewhere:
        message = (
            f"no torque found where the positions ({as_one([one.column for one in order])}) are; if "
            f"{listed(elsewhere)} is that of these joints, name it, as in --columns tau=NAME,NAME"
        )
    raise DataSetError(message, file=table.file)


def _kind_of_stated(called: Mapping[str, str], names: Sequence[str]) -> TorqueKind:
    """What the names of columns, or their units, say that they are."""
    currents = {one.column for named in torques_of(called, "current") for one in named}
    in_amperes = (plain(marked_unit(name, "tau")[1]) in CURRENTS for name in names)
    is_current = all(name in currents or one for name, one in zip(names, in_amperes, strict=True))
    return "current" if is_current or "current" in " ".join(names).lower() else "measured"


def _check_not_relative(torque: Sequence[Named], table: Table) -> None:
    for one in torque:
        if RELATIVE.search(one.column):
            message = (
                "a share of what the drive is rated for: multiply each joint's column by its rated torque "
                "[N m] or current [A] and name it without %"
            )
            raise DataSetError(message, file=table.file, row=table.header_row, column=one.column)


def _about(kind: TorqueKind, found: Sequence[Named]) -> str:
    what = as_one([one.column for one in found])
    if kind == "current":
        return (
            f"torque: {what} are drive currents; give --current-to-torque [N m/A] a joint, gear "
            "included, for parameters in SI units"
        )
    if kind == "commanded":
        return (
            f"torque: {what} were commanded, not measured: what the drives did not follow passes "
            "for the arm"
        )
    return f"torque: {what}, taken as measured at the joints"


def _nothing(table: Table, what: str, key: str) -> str:
    where = f"topic {table.name}: " if table.name else ""
    advice = (
        "record the log with it"
        if key == "tau" and table.name
        else f"name its columns, as in --columns {key}=NAME,NAME"
    )
    return f"{where}no {what} found; {advice}. Columns: {listed_columns(table)}"


def _told(order: Sequence[Named], names: Sequence[str]) -> str:
    if all(one.label == name for one, name in zip(order, names, strict=True)):
        return f"joints: {as_one([one.column for one in order])}, by the robot's own names"
    pairs = (f"{one.label or one.column} is {name}" for one, name in zip(order, names, strict=True))
    return f"joints: {as_one([one.column for one in order])}, where {', '.join(pairs)}"


def _units(named: Sequence[Named]) -> tuple[str, ...]:
    units = tuple(one.unit for one in named)
    return units[:1] if len(set(units)) == 1 else units
