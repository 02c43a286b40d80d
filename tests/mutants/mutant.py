"""The list of mutants, read."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Mutant:
    """One line changed.

    Attributes:
        claim: What its tests hold.
        file: Where, from the top of the checkout.
        before: What stands there, once.
        after: What is put in its place.
        tests: Those that must fail.
    """

    claim: str
    file: str
    before: str
    after: str
    tests: tuple[str, ...]


def mutated(mutant: Mutant, text: str) -> str:
    """The file's text with the change.

    Raises:
        ValueError: If what is to be changed does not stand there exactly once.
    """
    count = text.count(mutant.before)
    if count != 1:
        raise ValueError(f"{mutant.claim}: {mutant.before!r} occurs {count} times in {mutant.file}")
    return text.replace(mutant.before, mutant.after)


def _listed() -> tuple[Mutant, ...]:
    table = tomllib.loads(Path(__file__).with_name("mutants.toml").read_text(encoding="utf-8"))
    return tuple(
        Mutant(m["claim"], m["file"], m["before"], m["after"], tuple(m["tests"]))
        for m in table["mutant"]
    )


LISTED = _listed()
