"""Which columns a recording's file must and may have."""

from __future__ import annotations

import re
from dataclasses import dataclass

from oed.errors import DataSetError
from oed.experiment.toml_table import nearest

NUMBERED = re.compile(r"(q|dq|ddq|tau|temperature)_(\d+)")
REQUIRED = ("q", "tau")
OPTIONAL = ("dq", "ddq")


@dataclass(frozen=True)
class ColumnNames:
    """The columns found, by field of `Recording`, each in the order of the joints."""

    fields: dict[str, tuple[str, ...]]

    @property
    def all(self) -> tuple[str, ...]:
        """Every column found."""
        return tuple(name for names in self.fields.values() for name in names)


def find_columns(header: tuple[str, ...], joints: int, file: str) -> ColumnNames:
    """Assign a file's columns to the fields of a recording of `joints` joints.

    Raises:
        DataSetError: If a column is missing, or there are columns for another number of joints.
    """
    _check_joint_count(header, joints, file)
    fields: dict[str, tuple[str, ...]] = {"t": ("t",)}
    for quantity in REQUIRED:
        fields[quantity] = joint_columns(quantity, joints)
    for quantity in OPTIONAL:
        if any(name.startswith(f"{quantity}_") and NUMBERED.fullmatch(name) for name in header):
            fields[quantity] = joint_columns(quantity, joints)
    if "repetition" in header:
        fields["repetition"] = ("repetition",)
    sensors = sum(bool(re.fullmatch(r"temperature_\d+", name)) for name in header)
    if sensors:
        fields["temperature"] = joint_columns("temperature", sensors)
    found = ColumnNames(fields)
    for name in found.all:
        if name not in header:
            others = [other for other in header if other not in found.all]
            hint = f"; {nearest(name, others)}" if others else ""
            message = f"missing; the header must name it{hint}"
            raise DataSetError(message, file=file, row=1, column=name)
    return found


def joint_columns(quantity: str, joints: int) -> tuple[str, ...]:
    """The names quantity_1 … quantity_n."""
    return tuple(f"{quantity}_{i + 1}" for i in range(joints))


def _check_joint_count(header: tuple[str, ...], joints: int, file: str) -> None:
    for name in header:
        match = NUMBERED.fullmatch(name)
        if match is None or match[1] == "temperature":
            continue
        digits = match[2]
        if digits.startswith("0"):
            message = "columns are numbered 1, 2, … without leading zeros"
            raise DataSetError(message, file=file, row=1, column=name)
        if len(digits) > 6 or int(digits) > joints:
            message = (
                f"this column is of joint {digits[:12]}, but `joints` in dataset.toml lists "
                f"{joints}; name the missing joints there or remove the column"
            )
            raise DataSetError(message, file=file, row=1, column=name)
