"""What the study leaves: tables, the figures' data, claims, summary and provenance."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from oed.report.json_file import write_atomically, write_json
from oed.report.provenance import Provenance
from oed.report.table import write_csv
from studies.paper_experiment import figure_data as data
from studies.paper_experiment import tables
from studies.paper_experiment.claims import find_claims
from studies.paper_experiment.config import PERIOD, Config
from studies.paper_experiment.stages import DrakeCheck, Result
from studies.paper_experiment.summary import PaperRows, claim_rows, summarise

TABLES = (
    *(
        f"{name}.csv"
        for name in (
            "comparison",
            "horizons",
            "terms",
            "processing",
            "energy",
            "runs",
            "claims",
            "drake",
        )
    ),
    *(
        f"figures/{name}.csv"
        for name in (
            "trajectories",
            "designs",
            "generations",
            "torques",
            "recursion",
            "bode",
        )
    ),
)
FILES = (*TABLES, "figures/settings.json", "summary.md", "provenance.json")


def write(result: Result, config: Config, out: Path) -> None:
    """Tables, figure data, claims, summary and provenance."""
    truth = config.campaign.laboratory.truth()
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
    tabled = (
        rows.comparison,
        rows.horizons,
        rows.terms,
        rows.processing,
        rows.energy,
        rows.monte_carlo,
        claim_rows(claims),
        rows.drake,
        data.trajectories(result.designs, PERIOD),
        data.designs(result.designs),
        data.generations(result.designs),
        data.torques(result.single, horizon),
        data.recursion(result.single),
        data.bode(config.campaign, result.bench),
    )
    for name, listed in zip(TABLES, tabled, strict=True):
        write_csv(out / name, listed)
    write_json(
        out / "figures/settings.json", data.settings(config.designs, config.campaign, horizon)
    )
    write_atomically(out / "summary.md", summarise(rows))
    Provenance.collect(config, seed=config.campaign.seed).write(out / "provenance.json")
