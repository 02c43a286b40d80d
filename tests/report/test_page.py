from pathlib import Path

import numpy as np
import pytest

from oed.report.page import (
    Page,
    Picture,
    Section,
    Table,
    Text,
    Verdict,
    figure_data_uri,
    render_page,
    write_page,
)
from oed.report.style import new_figure, save_figure
from tests.report.html_reader import Reader


def figure():
    drawn = new_figure(3.4, 2.0)
    drawn.subplots().plot([0, 1], [0, 1])
    return drawn


def page(*blocks) -> Page:
    verdict = Verdict("good", "The model explains the torque.", "Relative rms 1.1 %.")
    return Page("Identification of <ur5>", verdict, [Section("Results", blocks)], footer="abc")


def test_needs_no_other_file(tmp_path: Path) -> None:
    png, _ = save_figure(figure(), tmp_path / "a")
    reader = Reader(
        render_page(
            page(Picture(figure(), "svg"), Picture(figure(), "png", "png"), Picture(png, "file"))
        )
    )
    assert len(reader.references) == 3
    assert all(reference.startswith("data:image/") for reference in reader.references)
    assert "script" not in reader.tags
    assert "link" not in reader.tags


def test_text_is_text_and_never_markup() -> None:
    attack = "<script>alert(1)</script>"
    html = render_page(
        page(Text(attack), Table([{attack: attack}], attack), Picture(figure(), f'"{attack}'))
    )
    assert "<script>" not in html
    assert "Identification of &lt;ur5&gt;" in html


def test_numbers_are_set_right_and_missing_ones_are_dashes() -> None:
    html = render_page(page(Table([{"joint": "a", "rms": np.float64(0.25)}, {"joint": "b"}])))
    assert '<td class="number">0.2500</td>' in html
    assert '<td class="number">–</td>' in html
    assert "<td>a</td>" in html


def test_the_same_figure_gives_the_same_text() -> None:
    assert figure_data_uri(figure()) == figure_data_uri(figure())


def test_refuses_a_file_that_no_browser_shows(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="only PNG and SVG"):
        render_page(page(Picture(tmp_path / "a.pdf", "figure")))


def test_is_written_whole(tmp_path: Path) -> None:
    write_page(tmp_path / "report" / "report.html", page(Text("x")))
    text = (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
    assert text.startswith("<!doctype html>")
    assert text.rstrip().endswith("</html>")
    assert 'class="verdict good"' in text


def test_folders_of_the_maker_are_not_told(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    shown = render_page(
        page(
            Text(f"no recording: '{file}': no shapes, see {file}."),
            Table([{"file": str(file), "m/s": "N m s/rad"}]),
            Text("publish to /joint_trajectory_controller/joint_trajectory; a/b/c; (N m)²/Hz"),
        )
    )
    assert str(tmp_path) not in shown
    assert "no recording: &#39;arm.urdf&#39;: no shapes, see arm.urdf." in shown
    assert "<td>arm.urdf</td>" in shown
    assert "/joint_trajectory_controller/joint_trajectory; a/b/c; (N m)²/Hz" in shown
    assert "N m s/rad" in shown
