"""Each claim of the paper, with numbers, intervals and a verdict."""

from __future__ import annotations

from collections.abc import Mapping

from jaxtyping import Float
from numpy import ndarray

from studies.paper_experiment import design_claims, run_claims
from studies.paper_experiment.campaign import FRICTIONS, ProcessingComparison
from studies.paper_experiment.designs import DesignSet, HorizonTable
from studies.paper_experiment.finding import Finding
from studies.paper_experiment.monte_carlo import MonteCarlo
from studies.paper_experiment.run_claims import Runs


def find_claims(
    table: HorizonTable,
    designs: DesignSet,
    monte_carlo: MonteCarlo,
    comparisons: Mapping[tuple[str, str], ProcessingComparison],
    truth: Float[ndarray, "8"],
) -> list[Finding]:
    """All findings, claim by claim."""
    findings = [
        *design_claims.generations(designs),
        *design_claims.more_terms(table),
        *design_claims.speed(table),
    ]
    processings = monte_carlo.processings.tolist()
    for friction in FRICTIONS:
        for processing in processings:
            runs = Runs.of(monte_carlo, friction, processing)
            findings += run_claims.prediction_error(runs)
            findings += run_claims.measured_variance(runs)
            findings += run_claims.static_friction(runs)
            findings += run_claims.infeasible_estimates(runs)
            if friction == "plain":
                findings += run_claims.exact_limits(runs, truth)
                findings += run_claims.covariance(runs)
    for processing in processings:
        plain, rich = (Runs.of(monte_carlo, f, processing) for f in ("plain", "rich"))
        findings += run_claims.richer_friction(plain, rich)
    findings += run_claims.static_friction_by_processing(comparisons)
    order = list(dict.fromkeys(f.claim for f in findings))
    return sorted(findings, key=lambda f: order.index(f.claim))
