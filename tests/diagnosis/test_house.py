"""What keeps the diagnosis readable: its size, its numbers in one place, and words that a stranger knows."""

import ast
import re

import pytest

from tests.paths import REPO

HOUSE = REPO / "oed" / "diagnosis"
FILES = sorted(HOUSE.rglob("*.py"))
MOST_LINES, MOST_FILES, LONGEST = 6500, 45, 300
MOST_NUMBERS = 25
# Each stood for something that statistics or robotics has a word for.
PRIVATE = (
    r"workshops?|workbench|trials?|ripen\w*|climbing|telling|foretold|foretell\w*|unseen|leftovers?|"
    r"mop-?ups?|turning|upright|pick-?ups|restraint\w*|free[- _]?forms?|standing in|calm\w*|standstill|"
    r"riddles?|withheld|contend\w*|exposing|sharpen\w*|side by side|shop"
)


def test_it_is_no_larger_than_a_person_reads():
    lines = [len(file.read_text(encoding="utf-8").splitlines()) for file in FILES]
    assert sum(lines) <= MOST_LINES
    assert len(FILES) <= MOST_FILES
    assert max(lines) <= LONGEST


def test_the_numbers_of_the_method_are_few_and_each_has_its_reason():
    text = (HOUSE / "numbers.py").read_text(encoding="utf-8")
    names = [
        name.id
        for node in ast.parse(text).body
        if isinstance(node, ast.Assign)
        for name in ast.walk(node.targets[0])
        if isinstance(name, ast.Name)
    ]
    assert len(names) <= MOST_NUMBERS, len(names)
    for line in text.splitlines():
        assert not re.match(r"[A-Z_, ]+ = [^(#]*$", line), f"{line}: why?"


@pytest.mark.parametrize("file", [*FILES, HOUSE / "METHOD.md"], ids=lambda f: f.stem)
def test_it_speaks_in_words_of_the_field(file):
    text = file.read_text(encoding="utf-8")
    found = re.findall(rf"(?i)\b(?:{PRIVATE})\b", text.replace("_", " "))
    assert not found, found
