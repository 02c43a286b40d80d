"""The site is built without a warning, every internal link leads somewhere, and nothing is loaded."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from oed.commands.main import COMMANDS
from oed.dynamics.effects.catalogue import CATALOGUE
from tests.browser import Browser
from tests.paths import REPO

pytestmark = pytest.mark.skipif(
    find_spec("mkdocs") is None, reason="MkDocs is not installed (it is in environment.txt)"
)
NOTEBOOKS = sorted((REPO / "docs/tutorials").glob("*.py"))
LOADED = re.compile(r'<(?:script|img|link|iframe)\b[^>]*?\b(?:src|href)="(https?:)?//[^"]+"')
PLACE = 'class="shown" id='
LARGEST_INDEX = 1_000_000  # [B]
# Tells search engines where the page belongs; browsers load nothing.
ONLY_NAMED = re.compile(r'<link rel="(?:canonical|prev|next)"[^>]*>')


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    done = subprocess.run(  # strict: every warning, a dead link or anchor, ends it
        command,
        cwd=REPO,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.parametrize("page", sorted(REPO.glob("*.md")), ids=lambda page: page.name)
def test_links_between_files_lead_somewhere(page: Path) -> None:
    """Of pages beside the site, as they are read in the repository."""
    links = re.findall(r"\]\((?!https?:|#|mailto:)([^)#\s]+)", page.read_text(encoding="utf-8"))
    missing = [link for link in links if not (page.parent / link).exists()]
    assert missing == []


def test_works_without_a_network(site: Path) -> None:
    for page in site.rglob("*.html"):
        text = ONLY_NAMED.sub("", page.read_text(encoding="utf-8"))
        assert LOADED.search(text) is None, page


def test_the_search_works_from_a_folder(site: Path, browser: Browser) -> None:
    """In a page within a folder too, whose addresses are relative to it."""
    for page in ("index.html", "reference/files.html"):
        found = browser.found(site / page, "pseudo-inertia")
        assert any("theory/feasibility.html" in address for address in found), found


def test_every_command_has_its_options_on_the_page(site: Path) -> None:
    text = (site / "reference/commands.html").read_text(encoding="utf-8")
    for name in COMMANDS:
        assert f'id="oed-{name}"' in text
    assert "<code>--sign-width</code>" in text
    assert "<code>0.9</code>" in text  # of --margin


def test_every_effect_has_its_page(site: Path) -> None:
    text = (site / "reference/effects.html").read_text(encoding="utf-8")
    assert [name for name in CATALOGUE if f'id="{name}"' not in text] == []


def test_no_formula_is_left_as_tex(site: Path) -> None:
    for page in site.rglob("*.html"):
        assert "arithmatex" not in page.read_text(encoding="utf-8"), page


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_shown_with_what_it_prints_and_draws(site: Path, notebook: Path) -> None:
    text = (site / "tutorials" / f"{notebook.stem}.html").read_text(encoding="utf-8")
    pictures = re.findall(r'<img alt="[^"]+" src="([^"]+)"', text)
    assert pictures
    for picture in pictures:
        assert (site / "tutorials" / picture).read_bytes().startswith(b"\x89PNG")
    assert text.count("<iframe srcdoc=") == 1
    assert text.count('class="shown no-copy highlight') > 3
    assert PLACE not in text
    # Of a picture nothing is searched for.
    index = (site / "search" / "search_index.json").read_text(encoding="utf-8")
    assert len(index) < LARGEST_INDEX


@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_s_arm_moves_within_the_window(
    site: Path, browser: Browser, notebook: Path, width: int
) -> None:
    seen = browser.look(site / "tutorials" / f"{notebook.stem}.html", width)
    assert seen.errors == ()
    assert not [address for address in seen.requests if address.startswith("http")]
    assert seen.width <= width
    (arm,) = seen.moving
    assert max(arm.filled) > 0.3
