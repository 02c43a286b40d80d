"""Run many independent cases: progress shown, nothing lost, on processes or on a Dask cluster.

Every finished case is one line, appended to a file in one write. A run that is interrupted and
started again does the cases that have no line yet, and those whose line was made by other code,
settings or data. A case that fails is a line too.
"""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
import multiprocessing
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from threadpoolctl import threadpool_limits

from oed.parallel_map import PROCESSES
from oed.process_end import end_with_parent, is_interrupt, without_interrupts
from oed.report.code_digest import code_digest
from oed.report.input_files import data_digest
from oed.report.json_file import plain_value, read_json, write_atomically
from oed.report.progress import progress
from oed.report.provenance import Provenance
from studies.row_file import Outcome, RowFile
from studies.study_options import CaseOptions

__all__ = [
    "CaseRunner",
    "Outcome",
    "RowFile",
    "all_failed",
    "failure",
    "is_finished",
    "work_through",
]

DIGITS = 16  # of a digest: enough that no two of a table are the same by chance
FAILED = "failed"


class KeyedCase(Protocol):
    """A case that can be sent to another process and told apart from all others."""

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        ...


CaseT = TypeVar("CaseT", bound=KeyedCase)


@dataclass(frozen=True)
class CaseRunner(Generic[CaseT]):
    """Works through cases.

    Attributes:
        work: What is done with a case; importable, as other processes have to find it.
        rows: Where the lines go.
        label: For the display.
        data: Data set or file that a case reads; None if none does.
        code: Modules that do the work besides the one of `work`, such as in other processes.
    """

    work: Callable[[CaseT], Outcome]
    rows: RowFile
    label: str
    data: Callable[[CaseT], Path] | None = None
    code: tuple[str, ...] = ()

    def digest(self, case: CaseT) -> str:
        """Hash of all that decides a case's line: code, settings, data."""
        kind = self.work if inspect.isfunction(self.work) else type(self.work)
        parts = [
            code_digest(_module_of(kind), *self.code),
            kind.__qualname__,
            _settings(self.work),
            _settings(case),
            "" if self.data is None else data_digest(self.data(case)),
        ]
        return hashlib.sha256(repr(parts).encode()).hexdigest()[:DIGITS]

    def run(self, cases: Sequence[CaseT], *, workers: int = 1, scheduler: str | None = None) -> int:
        """Do the cases that have no line yet; say how many those were.

        Args:
            cases: All cases.
            workers: Processes on this machine; 1 works in this process.
            scheduler: Address of a Dask scheduler that does the work instead.
        """
        digests = {case.key: self.digest(case) for case in cases}
        self.rows.prepare()
        done, before = self.rows.done(digests), self.rows.done()
        missing = [case for case in cases if case.key not in done]
        if kept := len(cases) - len(missing):
            there = f"{kept} of {len(cases)} lines are there and stay"
            print(f"{self.label}: {there}: same code, settings and data", file=sys.stderr)
        if old := sum(case.key in before for case in missing):
            print(
                f"{self.label}: {old} lines of other code or data are done again", file=sys.stderr
            )
        if scheduler is not None:
            finished = _on_cluster(self.work, missing, scheduler)
        elif workers > 1:
            finished = _on_processes(self.work, missing, workers)
        else:
            finished = ((case, _attempt(self.work, case)) for case in missing)
        for case, outcome in progress(finished, self.label, total=len(missing)):
            self.rows.append(case.key, outcome, digests[case.key])
        self.rows.tidy()
        return len(missing)


def _module_of(work: Callable | type) -> str:
    """The name under which others import it, also where it was run by `python -m`."""
    if work.__module__ != "__main__":
        return work.__module__
    specification = sys.modules["__main__"].__spec__
    return work.__module__ if specification is None else specification.name


def _attempt(work: Callable[[CaseT], Outcome], case: CaseT) -> Outcome:
    """The outcome of a case; what went wrong, where something did."""
    try:
        with threadpool_limits(limits=1):  # cases run side by side
            return work(case)
    except Exception as error:  # whatever one case does, the others go on
        if is_interrupt(error):
            raise KeyboardInterrupt from error
        return failure(error)


def is_finished(
    rows: RowFile,
    cases: Sequence[CaseT],
    configuration: object,
    digest: Callable[[CaseT], str] | None = None,
) -> bool:
    """Whether every case has its line and the folder's provenance is of this configuration.

    Writing the results again would then only replace where they say that they come from.

    Args:
        rows: The lines, beside them `provenance.json`.
        cases: All cases.
        configuration: The study's configuration, an instance of a dataclass.
        digest: Of a case, as `CaseRunner.digest`: a line of another is none. Any counts if None.
    """
    record = rows.path.parent / "provenance.json"
    digests = None if digest is None else {case.key: digest(case) for case in cases}
    if not record.is_file() or not {case.key for case in cases} <= rows.done(digests):
        return False
    return read_json(record).get("configuration") == plain_value(configuration)


def work_through(
    runner: CaseRunner[CaseT],
    cases: Sequence[CaseT],
    options: CaseOptions,
    configuration: object,
    write: Callable[[Path], None],
) -> int:
    """What a study of many cases does: those that are left, then its results; its exit status.

    Where all is done with this configuration nothing is written again.

    Args:
        runner: Works through the cases.
        cases: All cases.
        options: Of the command line.
        configuration: The study's, an instance of a dataclass.
        write: Leaves the results of the runner's rows in a folder.
    """
    if is_finished(runner.rows, cases, configuration, runner.digest):
        print(f"nothing left to do; {options.results} stays as it is")
        return 0
    with options.held() as results:
        runner.run(cases, workers=options.workers, scheduler=options.scheduler)
        with results.replaced() as new:
            write(new)
    return int(all_failed(runner.rows.rows()))


def leave_page(text: str, configuration: object, seed: int | None, out: Path) -> None:
    """Leave the page of a study's rows, and where they come from.

    Args:
        text: Of `summary.md`.
        configuration: The study's, an instance of a dataclass.
        seed: Of its first case; None where each row has its own.
        out: Folder, made where there is none.
    """
    out.mkdir(parents=True, exist_ok=True)
    write_atomically(out / "summary.md", text)
    Provenance.collect(configuration, seed=seed).write(out / "provenance.json")


def all_failed(rows: Sequence[Mapping[str, str]]) -> bool:
    """Whether there are lines, and each is of a case that failed."""
    return bool(rows) and all(map(is_failed, rows))


def is_failed(row: Mapping[str, str]) -> bool:
    """Whether a line is of a case that failed."""
    return row["status"].startswith(FAILED)


def failure(error: BaseException) -> Outcome:
    """The line of a case that failed."""
    return {"status": f"{FAILED}: {type(error).__name__}: {' '.join(str(error).split())[:200]}"}


def _on_processes(
    work: Callable[[CaseT], Outcome], cases: Sequence[CaseT], workers: int
) -> Iterator[tuple[CaseT, Outcome]]:
    """Outcomes from a pool; if a worker dies, the rest are tried one by one."""
    # Started afresh: a fork would copy the threads' locks of the numerical libraries.
    context = multiprocessing.get_context("spawn")
    left = dict.fromkeys(range(len(cases)))
    # Ctrl-C reaches every process: the workers end without a word, this one says what it leaves.
    begin = partial(
        ProcessPoolExecutor, mp_context=context, initializer=_one_of_many, initargs=(os.getpid(),)
    )
    with begin(workers) as pool:
        with without_interrupts():
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
        with begin(1) as pool:
            error = (alone := pool.submit(_attempt, work, cases[index])).exception()
        yield cases[index], failure(error) if error is not None else alone.result()


def _one_of_many(parent: int) -> None:
    """What a worker does first: it dies quietly, and leaves the other processors to the others."""
    end_with_parent(parent)
    os.environ[PROCESSES] = "1"


def _settings(value: object) -> object:
    """The fields of a dataclass that are no paths: where files lie changes no line."""
    if not dataclasses.is_dataclass(value) or isinstance(value, type):
        return None
    fields = ((f.name, getattr(value, f.name)) for f in dataclasses.fields(value))
    return [(name, field) for name, field in fields if not isinstance(field, Path)]


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
