"""Run many independent cases: progress shown, nothing lost, on processes or on a Dask cluster.

Every finished case is one line, appended to a file in one write. A run that is interrupted and
started again does the cases that have no line yet. A case that fails is a line too.
"""

from __future__ import annotations

import csv
import io
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from threadpoolctl import threadpool_limits

from oed.diagnosis.side_by_side import PROCESSES
from oed.report.json_file import plain_value, read_json
from oed.report.progress import progress
from studies.interrupt import is_interrupt


class KeyedCase(Protocol):
    """A case that can be sent to another process and told apart from all others."""

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        ...


CaseT = TypeVar("CaseT", bound=KeyedCase)
Outcome = Mapping[str, str | int | float]


@dataclass(frozen=True)
class RowFile:
    """A CSV file that only grows, a line a case.

    Attributes:
        path: The file.
        key_columns: Names of the columns of a case's key; they come first.
        value_columns: Names of the others.
    """

    path: Path
    key_columns: tuple[str, ...]
    value_columns: tuple[str, ...]

    @property
    def columns(self) -> tuple[str, ...]:
        """All columns in order."""
        return (*self.key_columns, *self.value_columns)

    def rows(self) -> list[dict[str, str]]:
        """The complete lines; one that an interruption cut short is left out.

        Raises:
            ValueError: If the file has other columns.
        """
        if not self.path.is_file():
            return []
        text = self.path.read_text(encoding="utf-8")
        lines = text[: text.rfind("\n") + 1].splitlines()
        if not lines:
            return []
        header, *body = csv.reader(lines)
        if tuple(header) != self.columns:
            raise ValueError(f"{self.path} has the columns {header}, not {list(self.columns)}")
        return [dict(zip(header, cells, strict=True)) for cells in body]

    def done(self) -> set[tuple[str, ...]]:
        """Keys of the complete lines."""
        return {tuple(row[column] for column in self.key_columns) for row in self.rows()}

    def prepare(self) -> None:
        """Make the file with its header, and end a line that was cut short."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        if not self.path.is_file() or not self.path.stat().st_size:
            self._append(self.columns)
        elif not self.path.read_bytes().endswith(b"\n"):
            whole = self.path.read_bytes()
            os.truncate(self.path, whole.rfind(b"\n") + 1)

    def append(self, key: tuple[str, ...], outcome: Outcome) -> None:
        """Add a case's line in one write."""
        self._append((*key, *(outcome.get(column, "") for column in self.value_columns)))

    def _append(self, cells: Sequence[str | int | float]) -> None:
        stream = io.StringIO()
        csv.writer(stream, lineterminator="\n").writerow(cells)
        handle = os.open(self.path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        try:
            os.write(handle, stream.getvalue().encode("utf-8"))
        finally:
            os.close(handle)


@dataclass(frozen=True)
class CaseRunner(Generic[CaseT]):
    """Works through cases.

    Attributes:
        work: What is done with a case; importable, as other processes have to find it.
        rows: Where the lines go.
        label: For the display.
    """

    work: Callable[[CaseT], Outcome]
    rows: RowFile
    label: str

    def run(self, cases: Sequence[CaseT], *, workers: int = 1, scheduler: str | None = None) -> int:
        """Do the cases that have no line yet; say how many those were.

        Args:
            cases: All cases.
            workers: Processes on this machine; 1 works in this process.
            scheduler: Address of a Dask scheduler that does the work instead.
        """
        self.rows.prepare()
        done = self.rows.done()
        missing = [case for case in cases if case.key not in done]
        if kept := len(cases) - len(missing):
            there = f"{kept} of {len(cases)} lines are there and stay, whatever code made them"
            print(f"{self.label}: {there}; another --out begins anew", file=sys.stderr)
        if scheduler is not None:
            finished = _on_cluster(self.work, missing, scheduler)
        elif workers > 1:
            finished = _on_processes(self.work, missing, workers)
        else:
            finished = ((case, _attempt(self.work, case)) for case in missing)
        for case, outcome in progress(finished, self.label, total=len(missing)):
            self.rows.append(case.key, outcome)
        return len(missing)


def _attempt(work: Callable[[CaseT], Outcome], case: CaseT) -> Outcome:
    """The outcome of a case; what went wrong, where something did."""
    try:
        with threadpool_limits(limits=1):  # cases run side by side
            return work(case)
    except Exception as error:  # whatever one case does, the others go on
        if is_interrupt(error):
            raise KeyboardInterrupt from error
        return failure(error)


def is_finished(rows: RowFile, cases: Sequence[KeyedCase], configuration: object) -> bool:
    """Whether every case has its line and the folder's provenance is of this configuration.

    Writing the results again would then only replace where they say that they come from.

    Args:
        rows: The lines, beside them `provenance.json`.
        cases: All cases.
        configuration: The study's configuration, an instance of a dataclass.
    """
    record = rows.path.parent / "provenance.json"
    if not record.is_file() or not {case.key for case in cases} <= rows.done():
        return False
    return read_json(record).get("configuration") == plain_value(configuration)


def failure(error: BaseException) -> Outcome:
    """The line of a case that failed."""
    return {"status": f"failed: {type(error).__name__}: {' '.join(str(error).split())[:200]}"}


def _on_processes(
    work: Callable[[CaseT], Outcome], cases: Sequence[CaseT], workers: int
) -> Iterator[tuple[CaseT, Outcome]]:
    """Outcomes from a pool; if a worker dies, the rest are tried one by one."""
    # Started afresh: a fork would copy the threads' locks of the numerical libraries.
    context = multiprocessing.get_context("spawn")
    left = dict.fromkeys(range(len(cases)))
    # Ctrl-C reaches every process: the workers end without a word, this one says what it leaves.
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_one_of_many) as pool:
        futures = {pool.submit(_attempt, work, case): i for i, case in enumerate(cases)}
        try:
            for future in as_completed(futures):
                if isinstance(future.exception(), BrokenProcessPool):
                    continue
                left.pop(futures[future])
                yield cases[futures[future]], future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    for index in left:
        with ProcessPoolExecutor(1, mp_context=context) as pool:
            error = (alone := pool.submit(_attempt, work, cases[index])).exception()
        yield cases[index], failure(error) if error is not None else alone.result()


def _one_of_many() -> None:
    """What a worker does first: it dies quietly, and leaves the other processors to the others."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    os.environ[PROCESSES] = "1"


def _on_cluster(
    work: Callable[[CaseT], Outcome], cases: Sequence[CaseT], address: str
) -> Iterator[tuple[CaseT, Outcome]]:
    """Outcomes from the workers of a Dask cluster."""
    # Imported here: only this path needs it, and it takes a second.
    from dask.distributed import Client  # noqa: PLC0415
    from dask.distributed import as_completed as as_each_completed  # noqa: PLC0415

    with Client(address) as client:
        crowded = [worker for worker, threads in client.nthreads().items() if threads != 1]
        if crowded:
            raise ValueError(
                f"{len(crowded)} workers have several threads: start them with --nthreads 1, "
                "or the CPU time of one case would contain that of others"
            )
        futures = [client.submit(_attempt, work, case, pure=False) for case in cases]
        index = {future.key: i for i, future in enumerate(futures)}
        for future in as_each_completed(futures):
            error = future.exception()
            outcome = failure(error) if error is not None else future.result()
            yield cases[index[future.key]], outcome
