"""Work on several processes: the results of one after another, and nothing left behind."""

import os
import signal
import time

import numpy as np
import psutil
import pytest

from oed.errors import DataSetError
from oed.parallel_map import MOST_BYTES, PROCESSES, parallel_map, processes


@pytest.fixture(autouse=True)
def _two(monkeypatch):
    monkeypatch.setenv(PROCESSES, "2")


def children() -> set[int]:
    """Processes that this one began and has not waited for: a browser of other tests may be among them."""
    return {child.pid for child in psutil.Process().children()}


def test_results_stand_in_the_order_of_the_items():
    assert parallel_map(lambda x: x**2, list(range(40))) == [x**2 for x in range(40)]


def test_nothing_is_made_of_nothing():
    assert parallel_map(lambda x: x, []) == []


def test_results_may_be_more_than_a_pipe_holds():
    made = parallel_map(lambda x: np.full(200_000, x), list(range(4)))
    assert [(own.shape, own[-1]) for own in made] == [((200_000,), x) for x in range(4)]


def test_one_process_works_where_the_system_does_not_count_them(monkeypatch):
    monkeypatch.delenv(PROCESSES)
    monkeypatch.delattr(os, "sched_getaffinity")
    assert processes() == 1


def test_the_first_error_in_the_order_of_the_items_is_raised_and_nothing_is_left_at_work():
    def work(x):
        time.sleep(0.05 if x == 2 else 0.0)
        if x >= 2:
            raise ValueError(f"{x} will not do")
        return x

    before = children()
    with pytest.raises(ValueError, match="2 will not do"):
        parallel_map(work, list(range(9)))
    assert children() == before


def test_an_error_arrives_with_its_evidence():
    def work(x):
        raise DataSetError(f"{x} is no number", file="a.csv", row=7, column="q_1")

    with pytest.raises(DataSetError, match="no number") as caught:
        parallel_map(work, list(range(9)))
    assert (caught.value.file, caught.value.row, caught.value.column) == ("a.csv", 7, "q_1")


def test_what_a_process_took_with_it_is_made_here():
    here = os.getpid()

    def work(x):
        if os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return x + 1

    assert parallel_map(work, list(range(9))) == list(range(1, 10))


def test_no_process_is_left_behind():
    before = children()
    parallel_map(lambda x: x, list(range(9)))
    assert children() == before


def test_what_is_at_work_side_by_side_is_not_divided_again():
    inner = parallel_map(
        lambda _: (os.getpid(), parallel_map(lambda _: os.getpid(), [0, 1])), [0, 1, 2]
    )
    for outer, within in inner:
        assert set(within) == {outer}
    assert processes() == 2


def test_what_has_to_come_back_as_itself_does():
    here, kept = os.getpid(), [object(), object()]

    def work(k):
        time.sleep(0.05)
        return os.getpid(), (kept[k % 2], [k])

    made = parallel_map(work, list(range(6)), same=kept)
    assert {process == here for process, _ in made} == {True, False}
    for k, (_, (one, other)) in enumerate(made):
        assert one is kept[k % 2]
        assert other == [k]


def test_what_cannot_be_handed_on_is_said():
    here = os.getpid()

    def work(_):
        time.sleep(0.05)
        return (lambda: 0) if os.getpid() != here else None

    with pytest.raises(TypeError, match="function cannot be handed on"):
        parallel_map(work, [0, 1, 2, 3])


def test_no_more_processes_take_part_than_memory_is_for():

    def work(_):
        time.sleep(0.05)
        return os.getpid()

    assert len(set(parallel_map(work, [0, 1, 2], bytes_each=MOST_BYTES))) == 2
    assert set(parallel_map(work, [0, 1, 2], bytes_each=MOST_BYTES + 1)) == {os.getpid()}


def test_a_number_of_processes_that_is_none_is_refused(monkeypatch):
    monkeypatch.setenv(PROCESSES, "many")
    with pytest.raises(ValueError, match="OED_PROCESSES='many'"):
        processes()
