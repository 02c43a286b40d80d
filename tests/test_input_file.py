"""Whatever a path leads to, it is read as a bounded file or refused in one line."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from oed.errors import LONGEST_MESSAGE, OedError, one_line
from oed.input_file import SizeLimit, UnreadableFile, read_file, read_json

SMALL = SizeLimit(1_000_000, "files of this kind are small")


def test_a_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"content")
    assert read_file(tmp_path / "a", SMALL) == b"content"
    with pytest.raises(FileNotFoundError):
        read_file(tmp_path / "b", SMALL)


def test_a_pipe_without_a_writer_does_not_hold_up(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(UnreadableFile, match=r"pipe: is a pipe, not a file"):
        read_file(tmp_path / "pipe", SMALL)


def test_what_is_no_file_is_named(tmp_path: Path) -> None:
    for path, what in ((Path("/dev/zero"), "a device"), (tmp_path, "a folder")):
        with pytest.raises(UnreadableFile, match=f"is {what}, not a file"):
            read_file(path, SMALL)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / "s"))
        with pytest.raises(UnreadableFile):
            read_file(tmp_path / "s", SMALL)


def test_a_file_of_the_wrong_size_is_not_read(tmp_path: Path) -> None:
    with (tmp_path / "large").open("wb") as file:
        file.truncate(30_000_000_000)  # sparse: it takes no room
    with pytest.raises(UnreadableFile, match=r"larger than 1 MB \(30000 MB\): files of this kind"):
        read_file(tmp_path / "large", SMALL)


def test_a_file_that_has_no_size_of_its_own_is_bounded_too() -> None:
    with pytest.raises(UnreadableFile, match="larger than 0 MB"):
        read_file("/proc/self/smaps", SizeLimit(100, "it is tiny"))


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "not JSON: Expecting value"),
        (b"{", "not JSON"),
        (b"\xff\xfe{}", "not UTF-8"),
        (b'{"a": NaN}', "NaN is not a number"),
        (b'{"a": [1, -Infinity]}', "-Infinity is not a number"),
        (b'{"a": 1e999}', "1e999 is too large"),
        (b"9" * 5000, "not JSON"),
        (b"[" * 500_000, "nested too deeply"),
        (b'{"a":' * 100_000, "nested too deeply"),
    ],
)
def test_json_that_is_none_is_refused(tmp_path: Path, content: bytes, why: str) -> None:
    (tmp_path / "a.json").write_bytes(content)
    with pytest.raises(UnreadableFile, match=why) as caught:
        read_json(tmp_path / "a.json")
    assert "\n" not in str(caught.value)


def test_json_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('\ufeff{"a": [1, 2.5, null]}', encoding="utf-8")
    assert read_json(tmp_path / "a.json") == {"a": [1, 2.5, None]}


def test_a_message_is_one_line_that_somebody_reads() -> None:
    assert one_line("two\n  lines") == "two lines"
    words = ", ".join(f"column_{i}" for i in range(1_000_000))
    told = str(OedError(f"begin: known: {words}; end"))
    assert told.startswith("begin: known: column_0,")
    assert told.endswith("column_999999; end")
    assert "letters left out" in told
    assert len(told) < LONGEST_MESSAGE + 100
