"""The folder for results is judged before the work."""

from pathlib import Path

import pytest

from oed.report.output_folder import check_output_folder


def test_a_folder_to_be_made_is_fine_and_is_not_made_yet(tmp_path: Path) -> None:
    check_output_folder(tmp_path / "a" / "b")
    check_output_folder(tmp_path)
    assert not (tmp_path / "a").exists()


@pytest.mark.parametrize("below", ["", "deeper/still"])
def test_a_file_is_no_folder_nor_is_anything_below_it(tmp_path: Path, below: str) -> None:
    file = tmp_path / "taken"
    file.touch()
    with pytest.raises(ValueError, match="is a file, not a folder"):
        check_output_folder(file / below)


def test_a_place_where_nothing_can_be_made_is_refused_though_it_may_seem_permitted() -> None:
    """To root, /proc looks like a folder that may be written."""
    with pytest.raises(ValueError, match="cannot be written"):
        check_output_folder(Path("/proc/oed"))


def test_a_link_to_nothing_is_called_so(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "gone")
    with pytest.raises(ValueError, match="link is a link to nothing"):
        check_output_folder(tmp_path / "link" / "out")
