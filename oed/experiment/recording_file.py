"""One recording's file, CSV or Parquet: named columns of finite numbers in and out.

CSV is parsed by pandas at once. Only when that shows a fault is the file walked cell
by cell (`csv_fault`) to say where it is.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from jaxtyping import Float
from numpy import ndarray

from oed.errors import DataSetError
from oed.experiment.csv_fault import NUMBER, find_fault
from oed.experiment.toml_table import LARGEST


@dataclass(frozen=True)
class Columns:
    """The columns of a file that were asked for, and the names of the others.

    Attributes:
        values: Finite numbers (N,) of each column.
        others: Names of the columns that were not read.
        first_row: Number of the first data row, as the user counts in this file.
    """

    values: Mapping[str, Float[ndarray, " samples"]]
    others: tuple[str, ...]
    first_row: int


Select = Callable[[tuple[str, ...]], Collection[str]]


def read_columns(path: Path, select: Select) -> Columns:
    """Read some columns of a recording's file.

    Args:
        path: A .csv or .parquet file.
        select: Given the names of all columns, those to read; it may raise `DataSetError`.

    Raises:
        DataSetError: If the file is missing, empty, truncated, not text, or a cell of a
            selected column is not a finite number below `LARGEST` in magnitude.
    """
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        message = "missing; correct `file` in dataset.toml or add the file"
        raise DataSetError(message, file=str(path)) from None
    except (OSError, ValueError) as error:
        raise DataSetError(f"cannot be read: {error}", file=str(path)) from error
    if not content.strip():
        raise DataSetError("empty; it needs a header and one row per sample", file=str(path))
    if path.suffix.lower() == ".parquet":
        return _read_parquet(content, path, select)
    return _read_csv(content, path, select)


def write_columns(path: Path, values: Mapping[str, ndarray]) -> None:
    """Write columns of equal length so that reading returns the same numbers to the last bit."""
    frame = pd.DataFrame(dict(values))
    if path.suffix.lower() == ".parquet":
        frame.to_parquet(path, index=False)
    else:
        frame.to_csv(path, index=False, lineterminator="\n")


def _read_csv(content: bytes, path: Path, select: Select) -> Columns:
    text = _decode(content, path).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    header_line, _, body = text.partition(b"\n")
    header = _header(header_line.decode(), path)
    wanted = select(header)
    # A blank line at the end is harmless; a last line without an end may have lost digits.
    is_complete = text.endswith(b"\n")
    body = body.rstrip(b"\n") + b"\n" if is_complete else body
    if not body.strip():
        raise DataSetError("holds a header but no row", file=str(path), row=2)
    fault = DataSetError("cannot be parsed as comma-separated numbers", file=str(path))
    if is_complete and _is_rectangular(body, len(header)):
        try:
            values = _parse(body, header, wanted)
        except (ValueError, OverflowError, pd.errors.ParserError) as error:
            fault = DataSetError(f"cannot be parsed: {error}", file=str(path))
        else:
            if all(_is_sound(column) for column in values.values()):
                return Columns(values, tuple(c for c in header if c not in wanted), first_row=2)
    raise find_fault(body.decode(), header, wanted, str(path), is_complete=is_complete) or fault


def _decode(content: bytes, path: Path) -> bytes:
    """The content without a byte-order mark, once it is known to be UTF-8 text."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise DataSetError("is UTF-16 text; save it as UTF-8", file=str(path))
    zero = content.find(b"\0")
    if zero >= 0:
        row = content[:zero].count(b"\n") + 1
        raise DataSetError("holds a zero byte; it is not a text file", file=str(path), row=row)
    try:
        content.decode("utf-8")
    except UnicodeDecodeError as error:
        row = content[: error.start].count(b"\n") + 1
        message = f"byte 0x{content[error.start]:02x} is not UTF-8 text; save the file as UTF-8"
        raise DataSetError(message, file=str(path), row=row) from error
    return content.removeprefix(b"\xef\xbb\xbf")


def _header(line: str, path: Path) -> tuple[str, ...]:
    if line.lstrip().startswith("#"):
        message = "a comment stands where the header belongs; remove it"
        raise DataSetError(message, file=str(path), row=1)
    for separator, name in ((";", "semicolons"), ("\t", "tabs"), (" ", "spaces")):
        if separator in line.strip(" ") and "," not in line:
            message = f"columns are separated by {name}; separate them by commas (decimal point)"
            raise DataSetError(message, file=str(path), row=1)
    header = tuple(name.strip().strip("\"'").strip() for name in line.split(","))
    if all(NUMBER.fullmatch(name) for name in header):
        message = (
            "holds numbers where the names of the columns belong; add a header line such as "
            "t,q_1,q_2,tau_1,tau_2 above them"
        )
        raise DataSetError(message, file=str(path), row=1)
    for i, name in enumerate(header):
        if not name:
            message = f"column number {i + 1} has no name; name it in the header or remove it"
            raise DataSetError(message, file=str(path), row=1)
    check_unique(header, path)
    return header


def check_unique(header: tuple[str, ...], path: Path) -> None:
    """Refuse a header that names a column twice."""
    if len(set(header)) == len(header):
        return
    twice = next(name for name in header if header.count(name) > 1)
    raise DataSetError("two columns have this name", file=str(path), row=1, column=twice)


def _is_rectangular(body: bytes, columns: int) -> bool:
    """Whether each line has one comma fewer than there are columns."""
    letters = np.frombuffer(body, dtype=np.uint8)
    ends = np.flatnonzero(letters == ord("\n"))
    commas = np.flatnonzero(letters == ord(","))
    upto = np.searchsorted(commas, ends)
    return bool((np.diff(upto, prepend=0) == columns - 1).all())


def _parse(
    body: bytes, header: tuple[str, ...], wanted: Collection[str]
) -> dict[str, Float[ndarray, " samples"]]:
    frame = pd.read_csv(
        io.BytesIO(body),
        header=None,
        names=list(range(len(header))),
        usecols=[i for i, name in enumerate(header) if name in wanted],
        dtype=np.float64,
        skip_blank_lines=False,
        quoting=csv.QUOTE_NONE,
        engine="c",
    )
    return {header[i]: frame[i].to_numpy() for i in frame.columns}


def _is_sound(column: Float[ndarray, " samples"]) -> bool:
    # NaN fails every comparison, so this is False for NaN and infinity too.
    return bool((np.abs(column) <= LARGEST).all())


def _read_parquet(content: bytes, path: Path, select: Select) -> Columns:
    try:
        file = pq.ParquetFile(io.BytesIO(content))
        header = tuple(file.schema_arrow.names)
    except (pa.ArrowException, OSError, ValueError, NotImplementedError) as error:
        raise DataSetError(f"is not a Parquet file: {error}", file=str(path)) from error
    check_unique(header, path)
    wanted = select(header)
    try:
        table = file.read(columns=[name for name in header if name in wanted], use_threads=False)
    except (pa.ArrowException, OSError, ValueError, NotImplementedError) as error:
        raise DataSetError(f"is a damaged Parquet file: {error}", file=str(path)) from error
    if table.num_rows == 0:
        raise DataSetError("holds no row", file=str(path))
    values = {name: _parquet_column(table.column(name), name, path) for name in table.column_names}
    return Columns(values, tuple(name for name in header if name not in wanted), first_row=1)


def _parquet_column(column: pa.ChunkedArray, name: str, path: Path) -> Float[ndarray, " samples"]:
    kind = column.type
    if not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
        message = f"holds {kind}, not numbers"
        raise DataSetError(message, file=str(path), column=name)
    values = np.asarray(column.to_numpy(), dtype=np.float64)
    unsound = np.flatnonzero(~(np.abs(values) <= LARGEST))
    if unsound.size:
        row = int(unsound[0])
        is_finite = np.isfinite(values[row])
        message = (
            f"{values[row]:g} is beyond {LARGEST:g}; check its unit"
            if is_finite
            else f"{values[row]:g} is not a number; remove the row or repair the log"
        )
        raise DataSetError(message, file=str(path), row=row + 1, column=name)
    return values
