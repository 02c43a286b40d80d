from pathlib import Path

import pytest
from PIL import Image

from oed.report.style import new_figure, save_figure


def drawing():
    figure = new_figure(3.4, 2.0)
    figure.subplots().plot([0, 1], [0, 1])
    return figure


def test_the_same_drawing_gives_the_same_files(tmp_path: Path) -> None:
    first = save_figure(drawing(), tmp_path / "a")
    second = save_figure(drawing(), tmp_path / "b")
    assert [f.name for f in first] == ["a.png", "a.pdf"]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_a_point_in_the_stem_is_kept(tmp_path: Path) -> None:
    png, _ = save_figure(drawing(), tmp_path / "cutoff_0.5")
    assert png.name == "cutoff_0.5.png"


def test_the_png_has_the_width_of_the_column(tmp_path: Path) -> None:

    png, _ = save_figure(drawing(), tmp_path / "a")
    with Image.open(png) as image:
        assert image.size == pytest.approx((3.4 * 200, 2.0 * 200))


def test_a_notebook_shows_a_figure_without_pyplot() -> None:
    assert new_figure(1.0, 1.0)._repr_png_().startswith(b"\x89PNG")
