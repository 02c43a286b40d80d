"""Ctrl-C ends a study in one line."""

import io
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from oed.commands.telling import say, speak
from oed.errors import LONGEST_MESSAGE
from oed.process_end import BAD_INPUT, NO_USABLE_RESULT, exit_status, leave
from studies.case_runner import CaseRunner, RowFile
from tests.paths import REPO


def interrupted() -> int:
    raise KeyboardInterrupt


def terminated() -> int:
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(60)  # until the signal is seen
    return 0


def interrupted_within(error: Exception) -> int:
    """As compiled code, or the loading of it, passes an interrupt on."""
    try:
        interrupted()
    except KeyboardInterrupt as interrupt:
        raise error from interrupt
    return 0


interrupted_in_compiled_code = partial(
    interrupted_within, SystemError("returned a result with an exception set")
)


@pytest.mark.parametrize(
    "main",
    [
        interrupted,
        terminated,
        interrupted_in_compiled_code,
        partial(interrupted_within, ImportError("initialization failed")),
    ],
)
def test_an_interrupt_is_one_line_and_status_130(main, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        leave(main, "studies.test")
    assert end.value.code == 130
    assert capsys.readouterr().err.strip() == "studies.test: interrupted: nothing was written"


def test_another_error_of_the_system_is_raised() -> None:
    def broken() -> int:
        raise SystemError("broken")

    with pytest.raises(SystemError, match="broken"):
        leave(broken, "studies.test")


def test_what_the_memory_does_not_hold_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    def large() -> int:
        return len(np.empty(2**50))

    assert exit_status(large, "oed test") == NO_USABLE_RESULT
    said = capsys.readouterr().err
    assert said.startswith("oed test: not enough memory: Unable to allocate 8.00 PiB")
    assert said.count("\n") == 1


class Only:
    key = ("a",)


def test_a_case_that_is_interrupted_is_no_case_that_failed(tmp_path: Path) -> None:
    rows = RowFile(tmp_path / "runs.csv", ("case",), ("status",))
    work = CaseRunner(lambda _: {"status": str(interrupted_in_compiled_code())}, rows, "cases")
    with pytest.raises(KeyboardInterrupt):
        work.run([Only()])
    assert not rows.rows()


def test_a_study_runs_on_one_thread_of_linear_algebra() -> None:
    seen = []

    def main() -> None:
        np.ones((2, 2)) @ np.ones((2, 2))
        seen.extend(p["num_threads"] for p in threadpool_info() if p["user_api"] == "blas")

    with threadpool_limits(limits=2), pytest.raises(SystemExit):
        leave(main, "a study")
    assert seen
    assert set(seen) == {1}


@pytest.mark.parametrize("how", ["numpy", "scipy"])
def test_an_interrupt_while_modules_load_is_one_line(tmp_path: Path, how: str) -> None:
    interrupting = "import os, signal, time\nos.kill(os.getpid(), signal.SIGINT)\ntime.sleep(60)\n"
    (tmp_path / f"{how}.py").write_text(interrupting)
    ended = subprocess.run(
        [sys.executable, "-m", "studies.identify", "--data", "nowhere", "--out", "nowhere"],
        cwd=REPO,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.stderr.strip() == "studies.identify: interrupted: nothing was written"
    assert ended.returncode == 130


@pytest.mark.parametrize(
    "error", [OSError(28, "No space left on device", "runs.csv"), ValueError("two\nlines")]
)
def test_what_cannot_be_done_is_one_line_and_status_2(
    error: Exception, capsys: pytest.CaptureFixture[str]
) -> None:
    def main() -> int:
        raise error

    with pytest.raises(SystemExit) as end:
        leave(main, "studies.test")
    assert end.value.code == 2
    told = capsys.readouterr().err
    assert told.startswith("studies.test: ")
    assert told.count("\n") == 1


def test_a_message_of_megabytes_is_one_line_that_somebody_reads(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fail() -> int:
        raise ValueError("unknown\ncolumns: " + ", ".join(map(str, range(1_000_000))))

    assert exit_status(fail, "oed identify") == BAD_INPUT
    told = capsys.readouterr().err
    assert told.startswith("oed identify: unknown columns: 0, 1, 2")
    assert told.count("\n") == 1
    assert len(told) < LONGEST_MESSAGE + 100


@pytest.mark.parametrize(
    ("stream", "status", "said"),
    [("| head -1", 0, ""), ("> /dev/full", 2, "oed test: [Errno 28] No space left on device\n")],
)
def test_a_reader_that_goes_and_a_full_disk_make_no_traceback(
    tmp_path: Path, stream: str, status: int, said: str
) -> None:
    program = (
        "import sys, time\n"
        "from oed.commands.telling import say, speak\n"
        "from oed.process_end import leave\n"
        "def main():\n"
        "    speak(quiet=False)\n"
        "    for k in range(3):\n"
        "        say('word ' * 20000)\n"
        "    print('done')\n"
        "    open('kept', 'w').close()\n"
        "leave(main, 'oed test')\n"
    )
    (tmp_path / "program.py").write_text(program, encoding="utf-8")
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", f"{sys.executable} program.py {stream}"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(REPO)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (status, said)
    assert (tmp_path / "kept").exists() == (status == 0)


def test_lines_go_to_what_is_standard_output_by_then(monkeypatch: pytest.MonkeyPatch) -> None:
    speak(quiet=False)
    later = io.StringIO()
    monkeypatch.setattr(sys, "stdout", later)
    say("found")
    assert later.getvalue() == "found\n"


def test_help_may_be_read_in_part():
    command = f"{sys.executable} -m oed --help | head -1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)  # noqa: S602  our own line
    assert done.stdout.startswith("usage: oed")
    assert done.stderr == ""
