"""What a notebook shows is on its page, and one that fails or warns ends the build."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType

import pytest

from tests.paths import REPO

pytest.importorskip("jupytext")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")


@pytest.fixture
def pages(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """As MkDocs loads its hooks: their folder is on the path."""
    monkeypatch.syspath_prepend(REPO / "docs")
    return importlib.import_module("notebook_pages")


def notebook(folder: Path, *cells: str) -> Path:
    path = folder / "shown.py"
    path.write_text("# %% [markdown]\n# # A title\n" + "".join(f"\n# %%\n{c}\n" for c in cells))
    return path


def test_all_kinds_of_output_are_shown_in_order(pages: ModuleType, tmp_path: Path) -> None:
    drawing = "import matplotlib.pyplot as plt\nplt.plot([0, 1])\nplt.show()"
    html = "from IPython.display import HTML\nHTML('<b>bold</b>')"
    path = notebook(tmp_path, "print('first')", drawing, html, "20 + 22")
    page = pages.run_notebook(path, tmp_path)
    places = [
        page.markdown.index(words)
        for words in ("# A title", "\nfirst\n", "](shown-1.png)", 'id="shown-shown-1"', "\n42\n")
    ]
    assert places == sorted(places)
    assert page.pictures["shown-1.png"].startswith(b"\x89PNG")
    assert page.html == {"shown-shown-1": "<b>bold</b>"}
    assert (
        page.placed('<p><div class="shown" id="shown-shown-1"></div></p>') == "<p><b>bold</b></p>"
    )
    with pytest.raises(ValueError, match="no place for shown-shown-1"):
        page.placed("<p>another page</p>")


def test_a_cell_that_fails_ends_the_build(pages: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(nbclient.exceptions.CellExecutionError, match="no such thing"):
        pages.run_notebook(notebook(tmp_path, "raise KeyError('no such thing')"), tmp_path)


def test_a_cell_that_warns_ends_the_build(pages: ModuleType, tmp_path: Path) -> None:
    cell = "import warnings\nwarnings.warn('an old name')"
    with pytest.raises(ValueError, match=r"a cell warns.*an old name"):
        pages.run_notebook(notebook(tmp_path, cell), tmp_path)
