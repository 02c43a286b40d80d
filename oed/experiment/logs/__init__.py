"""Log files of any kind, read as tables of named columns; users register readers of their own."""

from oed.experiment.logs.registry import known_suffixes, log_reader, read_log
from oed.experiment.logs.table import MOST_HELD, Log, Table, held, table_of

__all__ = [
    "MOST_HELD",
    "Log",
    "Table",
    "held",
    "known_suffixes",
    "log_reader",
    "read_log",
    "table_of",
]
