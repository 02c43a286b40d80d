"""What is said of a design in words."""

from typing import Literal

import pytest

from oed.design.bound.efficiency import DEfficiency
from oed.report.design_summary import efficiency_line


@pytest.mark.parametrize(("kind", "claims"), [("certified", True), ("estimated", False)])
def test_only_a_proven_bound_gives_a_least_efficiency(
    kind: Literal["certified", "estimated"], claims: bool
) -> None:
    line = efficiency_line(DEfficiency(0.225, kind, 21.0, "a periodic motion"))
    assert "0.225" in line
    assert ("at least" in line) == claims
    assert ("not proven" in line) != claims
