from dataclasses import dataclass

import numpy as np
import pytest

from studies.paper_experiment.stage_cache import StageCache, code_hash


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
        cache.key("numbers", [3], ["studies/paper_experiment/stage_cache.py"]),
    }
    assert len(keys) == 4


def test_code_is_hashed_by_content(tmp_path, monkeypatch):
    monkeypatch.setattr("studies.paper_experiment.stage_cache.ROOT", tmp_path)
    file = tmp_path / "a.py"
    hashes = []
    for text in ("x = 1", "x = 2", "x = 1"):
        file.write_text(text)
        code_hash.cache_clear()
        hashes.append(code_hash(("a.py",)))
    code_hash.cache_clear()
    assert hashes[0] == hashes[2] != hashes[1]


def test_a_stage_that_fails_leaves_nothing(tmp_path):
    cache = StageCache(tmp_path)

    def fail():
        raise RuntimeError("no")

    with pytest.raises(RuntimeError):
        cache.get("numbers", cache.key("numbers", [], []), Numbers, fail)
    assert not list(tmp_path.iterdir())
