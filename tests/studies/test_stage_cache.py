from dataclasses import dataclass

import numpy as np
import pytest

from oed.errors import OedError
from studies.paper_experiment.stage_cache import StageCache, packed


@dataclass(frozen=True)
class Numbers:
    values: np.ndarray
    total: np.ndarray


@dataclass(frozen=True)
class Draw:
    """Some random numbers; none of a negative one."""

    number: int
    count: int = 3

    @property
    def key(self):
        return (str(self.number),)


def drawn(case):
    return np.random.default_rng(case.number).normal(size=(1, case.count))


def draw(case):
    return packed({"values": drawn(case), "kind": np.array(2)})


def test_cases_are_done_once_and_every_digit_is_read_back(tmp_path):
    cache = StageCache(tmp_path)
    # The last takes more than the 131072 characters at which a reader of CSV stops by itself.
    cases = [Draw(1), Draw(2), Draw(3, 20_000)]
    before = cache.each("draws", ("number",), draw, cases[:1])
    found = cache.each("draws", ("number",), draw, cases)
    for case, arrays in zip(cases, found, strict=True):
        assert np.array_equal(arrays["values"], drawn(case))
        assert arrays["kind"] == 2
    assert np.array_equal(before[0]["values"], found[0]["values"])
    assert len((tmp_path / "draws.csv").read_text().splitlines()) == 1 + len(cases)
    last, *_ = cache.each("draws", ("number",), draw, cases[::-1])
    assert np.array_equal(last["values"], drawn(cases[-1]))
    assert len((tmp_path / "draws.csv").read_text().splitlines()) == 1 + len(cases)


def test_a_stage_with_a_failed_case_is_none(tmp_path):
    with pytest.raises(OedError, match=r"draws.csv: 1 of 2 failed: ValueError"):
        StageCache(tmp_path).each("draws", ("number",), draw, [Draw(1), Draw(-1)])


def test_computes_once_and_reads_back_the_same(tmp_path):
    cache, calls = StageCache(tmp_path), []

    def compute():
        calls.append(1)
        values = np.random.default_rng(len(calls)).normal(size=7)
        return Numbers(values, values.sum())

    key = cache.key("numbers", [3], [])
    first = cache.get("numbers", key, Numbers, compute)
    again = cache.get("numbers", key, Numbers, compute)
    assert len(calls) == 1
    assert np.array_equal(first.values, again.values)
    assert first.total == again.total


def test_another_setting_or_other_code_is_another_key(tmp_path):
    cache = StageCache(tmp_path)
    keys = {
        cache.key("numbers", [3], []),
        cache.key("numbers", [4], []),
        cache.key("others", [3], []),
        cache.key("numbers", [3], ["studies.paper_experiment.stage_cache"]),
    }
    assert len(keys) == 4


def test_a_damaged_file_is_made_anew(tmp_path, capsys):
    cache = StageCache(tmp_path)
    key = cache.key("numbers", [], [])
    made = Numbers(np.arange(3.0), np.array(3.0))
    cache.get("numbers", key, Numbers, lambda: made)
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    for damaged in (whole[: len(whole) // 2], b"", b"x" * 100):
        file.write_bytes(damaged)
        again = cache.get("numbers", key, Numbers, lambda: made)
        assert np.array_equal(again.values, made.values)
        assert "is made anew" in capsys.readouterr().out
        assert [path.name for path in tmp_path.iterdir()] == [file.name]
        assert len(file.read_bytes()) == len(whole)


def test_a_stage_that_fails_leaves_nothing(tmp_path):
    cache = StageCache(tmp_path)

    def fail():
        raise RuntimeError("no")

    with pytest.raises(RuntimeError):
        cache.get("numbers", cache.key("numbers", [], []), Numbers, fail)
    assert not list(tmp_path.iterdir())
