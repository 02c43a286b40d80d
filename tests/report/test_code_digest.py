"""A result's code is what its module does, with all of this project that it imports."""

from pathlib import Path

import pytest

from oed.report import code_digest as module
from oed.report.code_digest import code_digest

FILES = {
    "studies/__init__.py": "",
    "studies/top.py": '"""Top."""\nfrom oed import deep\nimport studies.beside\n',
    "studies/beside.py": "y = ['-m', 'studies.process']\n",
    "studies/process.py": "a = 1\n",
    "studies/unused.py": "z = 3\n",
    "oed/__init__.py": "",
    "oed/deep/__init__.py": "from oed.deep.inner import x\n",
    "oed/deep/inner.py": 'def x():\n    """X."""\n    return 1\n',
}


@pytest.fixture
def digest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(module, "CHECKOUT", tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)

    def of(name: str = "", text: str = "") -> str:
        if name:
            (tmp_path / name).write_text(text)
        code_digest.cache_clear()
        return code_digest("studies.top")

    yield of
    code_digest.cache_clear()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("oed/deep/inner.py", "def x():\n    return 2\n"),
        ("studies/beside.py", "y = 3\n"),
        ("studies/process.py", "a = 2\n"),
        ("oed/__init__.py", "import math\n"),
    ],
)
def test_what_is_imported_at_any_depth_counts(digest, name: str, text: str) -> None:
    before = digest()
    assert digest(name, text) != before
    assert digest(name, FILES[name]) == before


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("studies/unused.py", "z = 4\n"),
        ("oed/deep/inner.py", 'def x():\n    """Another."""\n\n    return 1  # one\n'),
        ("studies/top.py", "from oed import deep\nimport studies.beside\n"),
    ],
)
def test_what_changes_no_number_does_not(digest, name: str, text: str) -> None:
    assert digest() == digest(name, text)


def test_another_version_of_a_package_counts(digest, monkeypatch: pytest.MonkeyPatch) -> None:
    before = digest()
    monkeypatch.setattr(module, "package_versions", lambda _: {"numpy": "0.1"})
    assert digest() != before
