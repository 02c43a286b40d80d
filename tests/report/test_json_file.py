import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oed.report.json_file import plain_value, read_json, write_json

json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text()
    | st.floats(allow_nan=False, allow_infinity=False),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)  # fmt: skip


@given(json_values)
def test_plain_values_come_back_as_they_went(tmp_path_factory, value) -> None:
    file = tmp_path_factory.mktemp("json") / "value.json"
    write_json(file, value)
    assert read_json(file) == value


def test_numpy_values_become_plain_ones(tmp_path: Path) -> None:
    @dataclass(frozen=True)
    class Row:
        count: np.int64
        values: np.ndarray

    row = Row(np.int64(3), np.array([[1.0, 2.5]]))
    write_json(tmp_path / "row.json", {"row": row, "ok": np.True_, "x": np.float32(0.5)})
    assert read_json(tmp_path / "row.json") == {
        "row": {"count": 3, "values": [[1.0, 2.5]]},
        "ok": True,
        "x": 0.5,
    }


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, np.float64("nan")])
def test_what_json_cannot_say_is_null_with_its_place(tmp_path: Path, bad) -> None:
    file = tmp_path / "result.json"
    write_json(file, {"y": 2.0, "x": np.array([1.0, bad])})
    assert read_json(file) == {
        "y": 2.0,
        "x": [1.0, None],
        "not_finite": {"$.x[1]": str(float(bad))},
    }


def test_a_list_cannot_say_what_was_null_and_the_old_file_is_kept(tmp_path: Path) -> None:
    file = tmp_path / "result.json"
    write_json(file, {"x": 1})
    with pytest.raises(ValueError, match=r"\$\[1\] is nan"):
        write_json(file, [1.0, np.nan])
    assert read_json(file) == {"x": 1}
    assert list(tmp_path.iterdir()) == [file]
    with pytest.raises(ValueError, match=r"\$\.x is inf"):
        plain_value({"x": np.inf})


def test_refuses_nan_when_reading(tmp_path: Path) -> None:
    (tmp_path / "x.json").write_text('{"x": NaN}', encoding="utf-8")
    with pytest.raises(ValueError, match="NaN"):
        read_json(tmp_path / "x.json")


def test_refuses_a_type_without_counterpart() -> None:
    with pytest.raises(TypeError, match="complex"):
        plain_value({"z": 1j})
    with pytest.raises(TypeError, match="text keys"):
        plain_value({1: "one"})


def test_a_failed_rename_leaves_nothing_behind(tmp_path: Path, monkeypatch) -> None:
    def no_rename(self: Path, target: Path) -> None:
        raise OSError("disk gone")

    monkeypatch.setattr(Path, "replace", no_rename)
    with pytest.raises(OSError, match="disk gone"):
        write_json(tmp_path / "x.json", {"x": 1})
    assert list(tmp_path.iterdir()) == []


def test_text_stays_readable(tmp_path: Path) -> None:
    write_json(tmp_path / "x.json", {"unit": "kg m²"})
    text = (tmp_path / "x.json").read_text(encoding="utf-8")
    assert "kg m²" in text
    assert text.endswith("}\n")
    assert json.loads(text) == {"unit": "kg m²"}
