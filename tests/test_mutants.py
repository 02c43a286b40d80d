"""The list of mutants follows the code; `make mutants` runs them."""

import ast

import pytest

from tests.mutants.mutant import LISTED, Mutant, mutated
from tests.paths import REPO


@pytest.mark.parametrize("mutant", LISTED, ids=lambda m: m.claim)
def test_a_mutant_changes_the_code_that_is_there(mutant: Mutant) -> None:
    sound = (REPO / mutant.file).read_text(encoding="utf-8")
    changed = mutated(mutant, sound)
    assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(sound))
    assert all((REPO / test).exists() for test in mutant.tests)
    assert mutant.tests


def test_claims_are_told_apart() -> None:
    assert len({mutant.claim for mutant in LISTED}) == len(LISTED)
