from dataclasses import dataclass

import numpy as np
import pytest

from studies.paper_experiment.stage_cache import StageCache


@dataclass(frozen=True)
class Numbers:
    values: np.ndarray
    total: np.ndarray


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
