"""A log of many recordings is parsed once, and kept no longer than its last recording needs it."""

import gc
import weakref
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from oed.experiment.logs import Log, Table, read_log, registry
from oed.experiment.read_dataset import read_dataset
from tests.experiment.tiny_dataset import MANIFEST, ROWS, csv_text, write_files

RECORDING = '\n[[recording]]\nfile = "{}.counted"\nname = "{}"\nrole = "{}"\nrows = [{}, {}]\n'


class Parsed:
    """What a reader of numbers in text has parsed: how often each column, and which are kept."""

    def __init__(self) -> None:
        self.times: Counter[tuple[str, str]] = Counter()
        self.arrays: dict[str, list[weakref.ref[np.ndarray]]] = {}
        self.kept_at: dict[str, list[str]] = {}

    def read(self, path: Path) -> Log:
        gc.collect()
        self.kept_at[path.stem] = [
            file for file, refs in self.arrays.items() if any(ref() is not None for ref in refs)
        ]
        names, *rows = (line.split(",") for line in path.read_text().splitlines())

        def load(wanted: tuple[str, ...]) -> dict[str, np.ndarray]:
            self.times.update((path.stem, name) for name in wanted)
            found = {
                name: np.array([float(row[names.index(name)]) for row in rows]) for name in wanted
            }
            self.arrays.setdefault(path.stem, []).extend(map(weakref.ref, found.values()))
            return found

        return Log(str(path), (Table(tuple(names), load, str(path)),))


@pytest.fixture
def parsed(monkeypatch) -> Parsed:
    own = Parsed()
    monkeypatch.setitem(registry._readers, ".counted", own.read)
    return own


def data_set(folder: Path, *recordings: tuple[str, int]) -> Path:
    """Recordings of one length, each of a log and of its k-th rows."""
    roles = ("estimation", "validation", "test")
    head = MANIFEST.partition("\n[[recording]]")[0]
    entries = [
        RECORDING.format(file, f"{i}", roles[i % 3], k * ROWS + 1, (k + 1) * ROWS)
        for i, (file, k) in enumerate(recordings)
    ]
    files = {f"{file}.counted": csv_text(1, 3 * ROWS).encode() for file, _ in recordings}
    return write_files(folder, {"dataset.toml": (head + "".join(entries)).encode(), **files})


def test_each_column_once(tmp_path, parsed):
    folder = data_set(tmp_path, ("a", 0), ("b", 0), ("a", 1), ("a", 2), ("b", 1))
    found = read_dataset(folder)
    assert len(found.recordings) == 5
    assert len(parsed.times) == 10
    assert set(parsed.times.values()) == {1}
    whole = read_log(folder / "a.counted").tables[0].take(["q_2"])["q_2"]
    own = np.concatenate([r.q[:, 1] for r in found.recordings if r.source.endswith("a.counted")])
    assert np.array_equal(own, whole)


def test_a_log_is_let_go_with_its_last_recording(tmp_path, parsed):
    read_dataset(data_set(tmp_path, ("a", 0), ("b", 0), ("a", 1), ("c", 0), ("d", 0)))
    assert parsed.kept_at == {"a": [], "b": ["a"], "c": [], "d": []}


def test_a_log_that_changed_is_read_anew(tmp_path, parsed):
    folder = data_set(tmp_path, ("a", 0), ("a", 1))
    first = read_dataset(folder)
    (folder / "a.counted").write_text(csv_text(2, 3 * ROWS))
    assert not np.array_equal(read_dataset(folder).recordings[0].q, first.recordings[0].q)
