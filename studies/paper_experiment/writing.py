"""What the study leaves: tables, the figures' data, claims, summary and provenance."""

from __future__ import annotations

import dataclasses

from oed.report.json_file import write_atomically, write_json
from oed.report.provenance import Provenance
from oed.report.table import write_csv
from studies.paper_experiment import figure_data as data
from studies.paper_experiment import tables
from studies.paper_experiment.claims import find_claims
from studies.paper_experiment.config import PERIOD, Config
from studies.paper_experiment.stages import DrakeCheck, Result
from studies.paper_experiment.summary import PaperRows, claim_rows, summarise


def write(result: Result, config: Config) -> None:
    """Tables, figure data, claims, summary and provenance."""
    out, truth = config.out, config.campaign.laboratory.truth()
    horizon = float(result.horizons.chosen)
    claims = find_claims(
        result.horizons, result.designs, result.monte_carlo, result.processing, truth
    )
    rows = PaperRows(
        comparison=tables.comparison(
            config.designs, config.campaign, result.designs, result.bench, result.single
        ),
        horizons=tables.horizons(result.horizons),
        terms=tables.terms(result.horizons),
        processing=tables.processing(result.processing, truth),
        energy=tables.energy(result.energy, truth),
        monte_carlo=tables.monte_carlo(result.monte_carlo, truth),
        claims=claims,
        drake=tables.table_rows(
            {f.name: getattr(result.drake, f.name)[None] for f in dataclasses.fields(DrakeCheck)}
        ),
        horizon=horizon,
        samples=config.designs.samples,
        experiments=config.experiments,
    )
    for name, listed in (
        ("comparison", rows.comparison),
        ("horizons", rows.horizons),
        ("terms", rows.terms),
        ("processing", rows.processing),
        ("energy", rows.energy),
        ("runs", rows.monte_carlo),
        ("claims", claim_rows(claims)),
        ("drake", rows.drake),
        ("figures/trajectories", data.trajectories(result.designs, PERIOD)),
        ("figures/designs", data.designs(result.designs)),
        ("figures/generations", data.generations(result.designs)),
        ("figures/torques", data.torques(result.single, horizon)),
        ("figures/recursion", data.recursion(result.single)),
        ("figures/bode", data.bode(config.campaign, result.bench)),
    ):
        write_csv(out / f"{name}.csv", listed)
    write_json(
        out / "figures/settings.json", data.settings(config.designs, config.campaign, horizon)
    )
    write_atomically(out / "summary.md", summarise(rows))
    Provenance.collect(config, seed=config.campaign.seed).write(out / "provenance.json")
