"""Numbers that pages state of results are those of the committed rows."""

from __future__ import annotations

import csv
from collections import defaultdict

import pytest

from tests.paths import REPO


def rows_of(study: str) -> list[dict[str, str]]:
    """The committed rows of a study."""
    with (REPO / "results" / study / "runs.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def page(name: str) -> str:
    """A page's text in one line."""
    return " ".join((REPO / name).read_text(encoding="utf-8").split())


def test_the_start_page_says_how_often_intervals_hold_the_truth() -> None:
    held: dict[tuple[str, str], list[bool]] = defaultdict(list)
    for row in rows_of("pipeline_coverage"):
        printed = (entry.rsplit(":", 1)[1] == "1" for entry in row["intervals"].split())
        held[row["arm"], row["noise"]] += printed
    shares = [100 * sum(own) / len(own) for own in held.values()]
    assert f"{min(shares):.1f} to {max(shares):.1f} (`results/pipeline_coverage" in page(
        "docs/index.md"
    )


def test_the_bench_names_nothing_where_nothing_is_hidden() -> None:
    clean = [row["verdict"] for row in rows_of("bench") if row["group"] == "clean"]
    assert set(clean) == {"nothing found"}
    assert "named nothing on any clean data set of the bench" in page("docs/index.md")


def test_the_readme_says_the_verdict_on_the_public_arms() -> None:
    verdicts = [row["verdict"] for row in rows_of("public_arms")]
    assert verdicts == ["unexplained"] * 8
    assert "On all eight [public arms]" in page("README.md")
    gained = sorted(ratios("loop").values())
    assert gained[0] == pytest.approx(1 / 3, abs=0.03)
    assert 0.75 < gained[5] < 0.82
    assert 0.95 < gained[6] <= gained[7] <= 1
    assert "fell on six by a fifth to two thirds, and hardly on two" in page("README.md")


def ratios(model: str) -> dict[str, float]:
    """Relative error of a model of each public arm over the base model's."""
    rows = rows_of("public_arms")
    return {r["arm"]: float(r[f"relative_{model}"]) / float(r["relative_base"]) for r in rows}


def test_the_page_of_public_arms_says_what_the_diagnosis_gained_and_what_bodies_cost() -> None:
    gained = ratios("loop")
    assert max(gained.values()) <= 1  # on none is the error larger
    assert gained["TIAGo (Toulouse)"] == pytest.approx(1, abs=0.015)
    assert gained["TX40 (Nantes)"] == pytest.approx(1 / 3, abs=0.03)
    worse = {arm: ratio for arm, ratio in ratios("feasible").items() if ratio > 1}
    panda = worse.pop("Panda (Salerno)")
    assert panda == pytest.approx(1 + 1 / 8, abs=0.02)
    assert set(worse) == {"TIAGo (Toulouse)", "dVRK PSM (Worcester)"}
    assert min(worse.values()) > 1.2


def test_the_theory_page_says_the_bound_on_j_k() -> None:
    bound = max(float(row["J_k_bound"]) for row in rows_of("condition_bound"))
    assert f"below {bound - 0.005:.2f}, certified" in page("docs/theory/criteria.md")
