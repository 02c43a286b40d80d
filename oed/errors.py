"""Errors that carry their evidence.

`ValueError` is for a caller's mistake. An `OedError` is a numerical or data
outcome that a program may want to catch, inspect and report.
"""

from __future__ import annotations

from collections.abc import Callable

from numpy import ndarray

LONGEST_MESSAGE = 1500  # letters: a dozen lines of a terminal, which is what anybody reads


class OedError(Exception):
    """Base class of the package's errors: the input cannot be used, or has no usable result."""

    def __str__(self) -> str:
        """The message in one line of bounded length."""
        return one_line(super().__str__())

    def __reduce__(self) -> tuple[Callable[..., object], tuple[object, ...]]:
        """As it is, evidence and all, whatever its making asks for: a process may pass it on."""
        return _remade, (type(self), self.args, self.__dict__)


def one_line(message: object) -> str:
    """A message without line breaks, its middle left out where it is longer than one reads."""
    text = " ".join(str(message).split())
    if len(text) <= LONGEST_MESSAGE:
        return text
    start, end = 2 * LONGEST_MESSAGE // 3, LONGEST_MESSAGE // 3
    return f"{text[:start]} … ({len(text) - start - end} letters left out) … {text[-end:]}"


def _remade(
    kind: type[OedError], args: tuple[object, ...], evidence: dict[str, object]
) -> OedError:
    error = kind.__new__(kind, *args)
    error.args = args
    error.__dict__.update(evidence)
    return error


class RobotError(OedError):
    """A robot description cannot be used as it stands."""


class NoUsableResult(OedError):
    """What was asked for cannot be had, though the input is in order: nothing is handed out."""


class RankUndetermined(OedError):
    """The singular values show no clear gap, so the rank would be a guess.

    Attributes:
        singular_values: The evidence, largest first, of the normalised regressor.
    """

    def __init__(self, message: str, singular_values: ndarray) -> None:
        super().__init__(message)
        self.singular_values = singular_values


class DataSetError(OedError):
    """A data set on disk cannot be read as it stands.

    Attributes:
        file: The file at fault, as given to the reader.
        row: Its line, counted from 1 with the header as line 1 (in Parquet: the data row
            from 1); None where no single row is at fault.
        column: Name of the column, or of the key in `dataset.toml`; None where none is.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str,
        row: int | None = None,
        column: str | None = None,
    ) -> None:
        place = [file]
        if row is not None:
            place.append(f"row {row}")
        if column is not None:
            place.append(f"column {column!r}" if not file.endswith(".toml") else f"key {column!r}")
        super().__init__(f"{', '.join(place)}: {message}")
        self.file = file
        self.row = row
        self.column = column
        self.message = message

    def with_column(self, column: str) -> DataSetError:
        """This error about a column of another name."""
        return DataSetError(self.message, file=self.file, row=self.row, column=column)
