"""Parquet tables, columns of lists and times included: RTDE, LeRobot, pandas."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy import ndarray

from oed.errors import DataSetError
from oed.experiment.logs.clock_text import clock_seconds, is_clock
from oed.experiment.logs.csv_fault import NUMBER
from oed.experiment.logs.registry import log_reader
from oed.experiment.logs.stamps import seconds_of_day
from oed.experiment.logs.table import Log, Table
from oed.input_file import UnreadableFile, read_json, too_many_numbers

LIBRARY_ERRORS = (pa.ArrowException, OSError, ValueError, NotImplementedError)
LEROBOT_INFO = Path("meta", "info.json")  # says what the elements of a column of lists are
LEROBOT_DEPTH = 4  # folders between a LeRobot data set and its Parquet files, at most


@log_reader(".parquet")
def read_parquet(path: Path) -> Log:
    """Read a Parquet file.

    A column of lists becomes one column an element, `name[0]`, `name[1]` …, whose labels are the
    motors where a LeRobot data set around the file names them; a column of times becomes seconds
    since midnight, and so does one of times that are written out.

    Raises:
        DataSetError: If it is damaged or no Parquet file.
    """
    file = str(path)
    try:
        content = path.read_bytes()
        if not content:
            raise DataSetError("empty", file=file)
        parquet = pq.ParquetFile(io.BytesIO(content))
        schema = parquet.schema_arrow
    except LIBRARY_ERRORS as error:
        raise DataSetError(f"is not a Parquet file: {error}", file=file) from error
    if parquet.metadata.num_rows == 0:
        raise DataSetError("holds no row", file=file)
    widths = _widths(parquet, file)
    columns = {
        column: (field.name, i)
        for field in schema
        for i, column in enumerate(_elements(field.name, widths.get(field.name)))
    }
    twice = [name for name, times in Counter(schema.names).items() if times > 1]

    def load(names: tuple[str, ...]) -> Mapping[str, ndarray]:
        stored = list(dict.fromkeys(columns[name][0] for name in names))
        width = sum(widths.get(name, 1) for name in stored)
        reason = too_many_numbers(parquet.metadata.num_rows * width)
        if reason:  # a constant column takes no room in the file
            raise DataSetError(reason, file=file)
        table = _read(parquet, stored, file)
        arrays = {name: _numbers(table.column(name), name, file) for name in stored}
        return {
            name: arrays[field][:, i] if field in widths else arrays[field]
            for name in names
            for field, i in (columns[name],)
        }

    labels = _lerobot_labels(path, widths)
    times = tuple(field.name for field in schema if pa.types.is_timestamp(field.type))
    table = Table((*columns, *twice), load, file, labels=labels, times=times)
    return Log(file, (table,))


def _read(parquet: pq.ParquetFile, names: list[str], file: str) -> pa.Table:
    try:
        table = parquet.read(columns=names, use_threads=False)
    except LIBRARY_ERRORS as error:
        raise DataSetError(f"is a damaged Parquet file: {error}", file=file) from error
    told = parquet.metadata.num_rows
    if table.num_rows != told:
        message = f"is a damaged Parquet file: it says {told} rows and holds {table.num_rows}"
        raise DataSetError(message, file=file)
    return table


def _widths(parquet: pq.ParquetFile, file: str) -> dict[str, int]:
    """How many elements the lists of each column of lists have, by its first row."""
    lists = [field.name for field in parquet.schema_arrow if _is_list(field.type)]
    if not lists:
        return {}
    first = _read(parquet, lists, file).slice(0, 1)
    return {name: len(first.column(name)[0].as_py() or ()) for name in lists}


def _elements(name: str, width: int | None) -> tuple[str, ...]:
    return (name,) if width is None else tuple(f"{name}[{i}]" for i in range(width))


def _is_list(kind: pa.DataType) -> bool:
    is_one = (
        pa.types.is_list(kind) or pa.types.is_large_list(kind) or pa.types.is_fixed_size_list(kind)
    )
    return is_one and (
        pa.types.is_floating(kind.value_type) or pa.types.is_integer(kind.value_type)
    )


def _lerobot_labels(path: Path, widths: Mapping[str, int]) -> dict[str, str]:
    """`name[motor]` of each element, by the `meta/info.json` of the LeRobot data set."""
    info = next(
        (
            p / LEROBOT_INFO
            for p in list(path.resolve().parents)[:LEROBOT_DEPTH]
            if (p / LEROBOT_INFO).is_file()
        ),
        None,
    )
    if info is None:
        return {}
    try:
        content: Any = read_json(info)  # what is no mapping of mappings raises
        features = content["features"]
        names = {key: _flat(features[key].get("names")) for key in widths if key in features}
    except (OSError, UnreadableFile, LookupError, AttributeError, TypeError, ValueError) as error:
        raise DataSetError(f"cannot be understood: {error!r}", file=str(info)) from error
    return {
        column: f"{key}[{label}]"
        for key, labels in names.items()
        if len(set(labels)) == len(labels) == widths[key]
        for column, label in zip(_elements(key, widths[key]), labels, strict=True)
    }


def _flat(names: object) -> tuple[str, ...]:
    """Names as a list, or as LeRobot's {"motors": [...]}."""
    if isinstance(names, dict):
        names = [name for part in names.values() if isinstance(part, list) for name in part]
    return tuple(map(str, names)) if isinstance(names, list) else ()


def _numbers(column: pa.ChunkedArray, name: str, file: str) -> ndarray:
    """(N,) numbers, or (N, m) of a column of lists; what is null is not a number."""
    kind = column.type
    if pa.types.is_timestamp(kind):
        stamps = column.cast(pa.timestamp("ns", tz=kind.tz)).cast(pa.int64())
        seconds = np.full(len(stamps), np.nan)
        told = ~stamps.is_null().to_numpy()
        seconds[told] = seconds_of_day(stamps.drop_null().to_numpy())
        return seconds
    if pa.types.is_duration(kind):
        return column.cast(pa.duration("ns")).cast(pa.int64()).to_numpy() / 1e9
    if pa.types.is_string(kind) or pa.types.is_large_string(kind):
        return _written_out(column, name, file)
    if _is_list(kind):
        lengths = np.asarray(pc.list_value_length(column).fill_null(-1))
        other = np.flatnonzero(lengths != lengths[0])
        if other.size:
            message = f"holds {lengths[other[0]]} elements, and {lengths[0]} in the first row"
            raise DataSetError(message, file=file, row=int(other[0]) + 1, column=name)
        values = pc.list_flatten(column).to_numpy().astype(float)
        return values.reshape(len(lengths), -1)
    if not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
        raise DataSetError(f"holds {kind}, not numbers", file=file, column=name)
    return column.to_numpy()


def _written_out(column: pa.ChunkedArray, name: str, file: str) -> ndarray:
    """(N,) seconds of times that are written out."""
    cells = [str(cell) for cell in column.to_pylist()]
    if not is_clock(cells[0]):
        raise DataSetError(f"holds {column.type}, not numbers", file=file, column=name)
    seconds = clock_seconds(cells)
    wrong = next((i for i, cell in enumerate(seconds) if not NUMBER.fullmatch(cell)), None)
    if wrong is not None:
        message = f"holds text, not numbers or times: {cells[wrong][:40]!r}"
        raise DataSetError(message, file=file, row=wrong + 1, column=name)
    return np.array(seconds, dtype=float)
