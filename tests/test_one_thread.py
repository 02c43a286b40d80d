"""Linear algebra runs on one thread in every command and in what a notebook calls."""

from __future__ import annotations

import importlib
from typing import Never

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import oed
from oed.commands import main
from oed.commands.configurations import Demo


def threads() -> set[int]:
    np.ones((2, 2)) @ np.ones((2, 2))
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


class Begun(Exception):
    """Work began, on so many threads."""


def begin(*_: object, **__: object) -> Never:
    raise Begun(threads())


@pytest.mark.parametrize(
    ("name", "first"),
    [
        ("identify", "prepare"),
        ("check", "prepare"),
        ("identify_feasible", "prepare"),
        ("design_motion", "robot_of"),
        ("diagnose_data", "read_dataset"),
    ],
)
def test_what_a_notebook_calls(name: str, first: str, monkeypatch: pytest.MonkeyPatch) -> None:
    work = getattr(oed, name)
    monkeypatch.setattr(importlib.import_module(work.__module__), first, begin)
    with threadpool_limits(limits=2), pytest.raises(Begun) as begun:
        work("somewhere")
    assert begun.value.args == ({1},)


def test_libraries_that_a_command_loads_are_limited_as_well() -> None:
    def command(_: object) -> int:
        begin()
        return 0

    # Two threads, as a library that was loaded by then has of its own.
    with threadpool_limits(limits=2), pytest.raises(Begun) as begun:
        main._run(command, Demo(quiet=True))
    assert begun.value.args == ({1},)
