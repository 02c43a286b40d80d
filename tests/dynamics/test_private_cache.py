"""Compiled code is loaded only from where nobody else can write, and only if it is whole."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import casadi
import numpy as np
import pytest

from oed.dynamics import native, private_cache
from oed.dynamics.kernel import kernel
from oed.dynamics.native import native_function
from oed.dynamics.private_cache import private_folder

needs_compiler = pytest.mark.skipif(
    native._compiler() is None, reason="there is no C compiler on this machine"
)


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty place for caches, and the folder of libraries in it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "oed" / "native"


def square() -> float:
    """The compiled square of three, whether from the cache or not."""
    x = casadi.SX.sym("x")
    batches = native_function([casadi.Function("square", [x], [x * x])])
    assert batches is not None
    return float(batches[0](np.array([[3.0]]))[0, 0])


def counted(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """A list that grows with each call of the compiler."""
    calls: list[object] = []
    run = subprocess.run
    monkeypatch.setattr(
        native.subprocess, "run", lambda *a, **k: (calls.append(a), run(*a, **k))[1]
    )
    return calls


@needs_compiler
def test_what_is_whole_is_compiled_once(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = counted(monkeypatch)
    before = os.umask(0o002)  # with which a compiler's output is writable by the group
    try:
        assert square() == square() == 9.0
    finally:
        os.umask(before)
    assert len(calls) == 1
    (kept,) = cache.iterdir()
    assert kept.stat().st_mode & 0o077 == 0
    assert cache.stat().st_mode & 0o077 == 0


@needs_compiler
@pytest.mark.parametrize("damage", ["cut", "changed", "link", "writable"])
def test_what_is_not_whole_or_not_ours_is_made_anew(
    cache: Path, monkeypatch: pytest.MonkeyPatch, damage: str
) -> None:
    assert square() == 9.0
    (kept,) = cache.iterdir()
    content = kept.read_bytes()
    # A new file: the old one is still mapped by this process.
    kept.unlink()
    if damage == "link":
        (cache / "elsewhere").write_bytes(content)
        kept.symlink_to(cache / "elsewhere")
    else:
        kept.write_bytes(
            {"cut": content[:2000], "changed": content[:-1] + b"x"}.get(damage, content)
        )
        kept.chmod(0o777 if damage == "writable" else 0o700)
    calls = counted(monkeypatch)
    assert square() == 9.0
    assert len(calls) == 1
    assert square() == 9.0
    assert len(calls) == 1


@needs_compiler
@pytest.mark.parametrize("fault", ["world-writable", "foreign", "a link", "a file"])
def test_a_cache_that_is_not_ours_alone_is_left_alone(
    cache: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    fault: str,
) -> None:
    assert square() == 9.0
    if fault == "world-writable":
        cache.chmod(0o777)
    elif fault == "foreign":
        monkeypatch.setattr(private_cache.os, "getuid", lambda: cache.stat().st_uid + 12345)
    else:
        moved = cache.rename(cache.with_name("moved"))
        cache.symlink_to(moved) if fault == "a link" else cache.write_text("")
    before = sorted(cache.iterdir()) if cache.is_dir() else []
    calls = counted(monkeypatch)
    assert square() == 9.0
    assert len(calls) == 1  # nothing was loaded
    assert str(cache.parent) in caplog.text
    assert (sorted(cache.iterdir()) if cache.is_dir() else []) == before


def test_loops_are_kept_in_a_private_folder(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def twice(x):  # a number
        return 2 * x

    assert kernel(twice)(21) == 42
    folder = private_folder("numba")
    assert folder is not None
    assert list(folder.rglob("*.nbi"))
    folder.chmod(0o777)
    assert private_folder("numba") is None
    assert kernel(twice)(21) == 42


def test_a_damaged_loop_is_compiled_anew(cache: Path) -> None:
    def thrice(x):  # a number
        return 3 * x

    assert kernel(thrice)(2) == 6
    folder = private_folder("numba")
    assert folder is not None
    for pattern in ("*.nbi", "*.nbc"):
        for file in folder.rglob(pattern):
            file.write_bytes(file.read_bytes()[:40])
        assert kernel(thrice)(2) == 6
        again = kernel(thrice)
        assert again(2) == 6
        assert sum(again.stats.cache_hits.values()) == 1  # it was kept once more


def test_a_cache_named_by_the_environment_is_not_unpickled(tmp_path: Path) -> None:
    """NUMBA_CACHE_DIR may be anybody's."""
    elsewhere = tmp_path / "numba"
    elsewhere.mkdir(mode=0o777)
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": str(elsewhere),
        "XDG_CACHE_HOME": str(tmp_path / "own"),
        "PYTHONPATH": str(Path(__file__).parents[2]),  # a script's own folder is not the project's
    }
    loop = tmp_path / "loop.py"
    loop.write_text(
        "from oed.dynamics.kernel import kernel\n"
        "@kernel\ndef twice(x):\n    return 2 * x\n"
        "assert twice(21) == 42\n"
    )
    subprocess.run([sys.executable, str(loop)], env=environment, check=True, timeout=120)
    assert not list(elsewhere.iterdir())
    assert list((tmp_path / "own" / "oed" / "numba").rglob("*.nbi"))
