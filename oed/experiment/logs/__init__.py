"""Log files of any kind, read as tables of named columns; users register readers of their own."""

from oed.experiment.logs.registry import known_suffixes, log_reader, read_log
from oed.experiment.logs.table import Log, Table, held, table_of

__all__ = ["Log", "Table", "held", "known_suffixes", "log_reader", "read_log", "table_of"]
