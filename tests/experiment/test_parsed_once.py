"""A log of many recordings is parsed once, and kept no longer than its last recording needs it."""

import gc
import weakref
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from oed.experiment.importing.import_log import ImportChoices, propose_import
from oed.experiment.logs import Log, Table, held, read_log, registry, table_of
from oed.experiment.read_dataset import read_dataset
from tests.experiment.tiny_dataset import MANIFEST, ROWS, csv_text, write_files

RECORDING = '\n[[recording]]\nfile = "{}.counted"\nname = "{}"\nrole = "{}"\nrows = [{}, {}]\n'


class Parsed:
    """What a reader of numbers in text has parsed: how often each column, and which are kept."""

    def __init__(self) -> None:
        self.files: Counter[str] = Counter()
        self.times: Counter[tuple[str, str]] = Counter()
        self.arrays: dict[str, list[weakref.ref[np.ndarray]]] = {}
        self.kept_at: dict[str, list[str]] = {}

    def read(self, path: Path) -> Log:
        self.files[path.stem] += 1
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


def test_an_import_parses_its_logs_once_as_well(tmp_path, parsed):
    paths = [tmp_path / f"{name}.counted" for name in ("a", "b")]
    for seed, path in enumerate(paths):
        path.write_text(csv_text(seed, 3 * ROWS))
    found = propose_import(paths, ImportChoices("builtin:imi_scara"), tmp_path / "set")
    assert [len(recording.t) for recording in found.dataset.recordings] == [3 * ROWS, 3 * ROWS]
    assert parsed.files == {"a": 1, "b": 1}
    assert {name for file, name in parsed.times if file == "a"} >= {"t", "q_1", "tau_2"}
    assert set(parsed.times.values()) == {1}


def test_columns_are_kept_up_to_a_size():
    loaded: list[tuple[str, ...]] = []
    arrays = {name: np.arange(10.0) for name in "abc"}
    table = table_of(arrays, "x")

    def load(names: tuple[str, ...]):
        loaded.append(names)
        return table.load(names)

    own = Table(table.columns, load, "x")
    first, second = held(Log("x", (own, own)), most=2 * 80).tables
    for _ in range(2):
        assert np.array_equal(first.read(["a"])["a"], arrays["a"])
        assert np.array_equal(second.read(["b"])["b"], arrays["b"])
        assert np.array_equal(first.read(["c", "a"])["c"], arrays["c"])
    assert loaded == [("a",), ("b",), ("c",), ("c",)]
