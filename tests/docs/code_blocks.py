"""The blocks of code on the pages of the documentation."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from tests.paths import REPO

# Notebooks hold their text in comments.
COMMENT = re.compile(r"^# ?", re.MULTILINE)
STUDY = re.compile(r"python -m studies\.[^`\n]+")
# Where the command line of a study of several files is read.
IN_PACKAGES = {
    "studies.bench": "studies.bench.study",
    "studies.estimators": "studies.estimators.study",
    "studies.paper_experiment": "studies.paper_experiment.experiment",
    "studies.public_arms": "studies.public_arms.study",
}


def pages() -> list[Path]:
    """All texts that show commands: the readme, pages and notebooks."""
    docs = REPO / "docs"
    return [
        REPO / "README.md",
        REPO / "CONTRIBUTING.md",
        *sorted(docs.rglob("*.md")),
        *sorted(docs.glob("tutorials/*.py")),
    ]


def study_lines() -> list[str]:
    """Command lines of studies, in blocks and within sentences."""
    return sorted(
        {line for page in pages() for line in STUDY.findall(page.read_text(encoding="utf-8"))}
    )


def blocks(page: Path, language: str) -> list[str]:
    """The fenced blocks of one language on a page, in order."""
    text = page.read_text(encoding="utf-8")
    if page.suffix == ".py":
        text = COMMENT.sub("", text)
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def command_words(line: str) -> list[str]:
    """The words of a command line."""
    return shlex.split(line, comments=True)


def oed_lines_in_sentences() -> set[tuple[str, ...]]:
    """Whole command lines of `oed` outside of blocks: those that say where results go."""
    return {
        tuple(command_words(line)[1:])
        for page in pages()
        for line in re.findall(r"`(oed [^`\n]*--out [^`\n]*)`", page.read_text(encoding="utf-8"))
    }


def oed_lines() -> dict[tuple[str, ...], Path]:
    """What `oed` is told on any page in a block, once each, with the first page that shows it."""
    found: dict[tuple[str, ...], Path] = {}
    for page in pages():
        for block in blocks(page, "bash"):
            for line in block.splitlines():
                if line.startswith("oed "):
                    found.setdefault(tuple(command_words(line)[1:]), page)
    return found
