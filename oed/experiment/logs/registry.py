"""Which function reads which kind of log file; users add their own.

A reader is a function of a path that returns a `Log`. It is registered by `log_reader`, or found in
the entry points of installed packages under `oed.log_readers`, whose modules do the same.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from oed.errors import DataSetError
from oed.experiment.logs.stamps import with_stamps
from oed.experiment.logs.table import Log
from oed.input_file import MOST_COLUMNS, RECORDING_FILE, UnreadableFile, check_file
from oed.registered import load_entry_points

LogReader = Callable[[Path], Log]
Reader = TypeVar("Reader", bound=LogReader)

ENTRY_POINTS = "oed.log_readers"
# What a file of each kind needs is imported when the first of that kind is read.
OWN = {
    "oed.experiment.logs.csv_log": (".csv", ".txt", ".tsv", ".dat"),
    "oed.experiment.logs.parquet_log": (".parquet",),
    "oed.experiment.logs.array_files": (".npz", ".mat", ".h5", ".hdf5"),
    "oed.experiment.logs.ros_bag": (".db3", ".mcap", ".bag"),
}
BAG_FOLDER = "metadata.yaml"  # a folder with it is a rosbag2
_readers: dict[str, LogReader] = {}


def log_reader(*suffixes: str) -> Callable[[Reader], Reader]:
    """Register a reader of files with these suffixes, such as ".log".

    A later registration takes the place of an earlier one, the built-in readers included.

    Example:
        >>> @log_reader(".mylog")
        ... def read_my_log(path: Path) -> Log:
        ...     return Log(str(path), (table_of(my_arrays(path), str(path)),))

    Raises:
        ValueError: If a suffix does not start with a dot.
    """
    for suffix in suffixes:
        if not suffix.startswith(".") or suffix == ".":
            raise ValueError(f"suffix {suffix!r} must start with a dot, as in '.log'")

    def register(reader: Reader) -> Reader:
        for suffix in suffixes:
            _readers[suffix.lower()] = reader
        return reader

    return register


def known_suffixes() -> tuple[str, ...]:
    """Suffixes of the files that can be read."""
    load_entry_points(ENTRY_POINTS)
    built_in = (suffix for suffixes in OWN.values() for suffix in suffixes)
    return tuple(dict.fromkeys((*built_in, *_readers)))


def read_log(path: Path) -> Log:
    """Read a log file by its suffix, or a folder that is a rosbag2.

    Raises:
        DataSetError: If it is missing, of an unknown kind, or cannot be read.
    """
    is_bag = path.is_dir() and (path / BAG_FOLDER).is_file()
    suffix = ".db3" if is_bag else path.suffix.lower()
    if suffix not in known_suffixes():
        message = (
            f"logs of kind {suffix or 'without a suffix'!r} are not known; known are "
            f"{', '.join(known_suffixes())} and folders of ROS 2 bags: write the log as one of these, a "
            "spreadsheet as .csv"
        )
        raise DataSetError(message, file=str(path))
    if not is_bag:
        _check(path)
    log = _reader_of(suffix)(path)
    for table in log.tables:
        if len(table.columns) > MOST_COLUMNS:
            message = (
                f"holds {len(table.columns)} columns, more than {MOST_COLUMNS}: a log has a row "
                "per sample, and some columns per joint"
            )
            raise DataSetError(message, file=str(path))
    return replace(log, tables=tuple(map(with_stamps, log.tables)))


def _check(path: Path) -> None:
    try:
        check_file(path, RECORDING_FILE)
    except FileNotFoundError:
        message = "missing; correct `file` in dataset.toml or add the file"
        raise DataSetError(message, file=str(path)) from None
    except UnreadableFile as error:
        raise DataSetError(error.reason, file=str(path)) from error


def _reader_of(suffix: str) -> LogReader:
    if suffix not in _readers:
        module = next(name for name, suffixes in OWN.items() if suffix in suffixes)
        registered = dict(_readers)
        importlib.import_module(module)
        _readers.update(registered)  # the user's own stay
    return _readers[suffix]
