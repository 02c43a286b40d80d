"""What the study leaves: tables, the figures' data, claims, summary and provenance."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from oed.report.json_file import read_json, write_atomically, write_json
from oed.report.provenance import Provenance
from oed.report.table import write_csv
from studies.paper_experiment import figure_data as data
from studies.paper_experiment import findings, tables
from studies.paper_experiment.config import Config
from studies.paper_experiment.stages import DrakeCheck, Result
from studies.paper_experiment.summary import PaperRows, summarise

TABLES = ("comparison", "horizons", "cells", "claims", "drake")
DRAWN = ("trajectories", "designs", "generations", "torques", "recursion", "bode")
FILES = (
    *(f"{name}.csv" for name in TABLES),
    *(f"figures/{name}.csv" for name in DRAWN),
    "figures/settings.json",
    "summary.md",
    "provenance.json",
)
# Of a provenance, what tells one run from another that gives the same results.
OF_A_RUN = ("commit", "dirty", "date", "cpu", "python", "platform")


def write(result: Result, config: Config, out: Path) -> None:
    """Tables, figure data, claims, summary and provenance.

    Args:
        result: Of all stages.
        config: Behind it.
        out: A new folder; `config.out` still holds what an earlier run left.
    """
    rows = _tables(result, config)
    for name in TABLES:
        write_csv(out / f"{name}.csv", getattr(rows, name))
    drawn = (
        data.trajectories(result),
        data.designs(result),
        data.generations(result),
        data.torques(result),
        data.recursion(result),
        data.bode(config.laboratory, result.bench),
    )
    for name, listed in zip(DRAWN, drawn, strict=True):
        write_csv(out / "figures" / f"{name}.csv", tables.rounded(listed, data.DIGITS))
    write_json(out / "figures/settings.json", data.settings(config, result))
    write_atomically(out / "summary.md", summarise(rows))
    Provenance.collect(config, seed=config.laboratory.seed).write(out / "provenance.json")
    keep_provenance(out, config.out)


def _tables(result: Result, config: Config) -> PaperRows:
    """All tables, with the digits that they carry."""
    truth = config.laboratory.laboratory.truth()
    found = [
        *findings.of_searches(result.searches),
        *findings.of_speed(result.speed()),
        *findings.of_campaign(result.campaign, truth),
    ]
    compared = tables.comparison(config.laboratory, result.bench, result.searches, result.campaign)
    drake = {f.name: getattr(result.drake, f.name)[None] for f in dataclasses.fields(DrakeCheck)}
    return PaperRows(
        comparison=tables.rounded(compared),
        horizons=tables.rounded(tables.horizons(result.horizons)),
        cells=tables.rounded(tables.cells(result.campaign, truth)),
        claims=tables.rounded(tables.claims(found)),
        # Differences of rounding and step size: their size is what can be told.
        drake=tables.rounded(tables.table_rows(drake), 2),
        findings=found,
        horizon=float(result.horizons.chosen),
        config=config,
    )


def keep_provenance(new: Path, old: Path) -> None:
    """Let the earlier provenance stand where a rerun gave the same results from the same settings."""
    others = [name for name in FILES if name != "provenance.json"]
    if not all((old / name).is_file() for name in FILES):
        return
    if any((new / name).read_bytes() != (old / name).read_bytes() for name in others):
        return
    files = (new / "provenance.json", old / "provenance.json")
    told, before = (
        {key: value for key, value in read_json(file).items() if key not in OF_A_RUN}
        for file in files
    )
    if told == before:
        files[0].write_bytes(files[1].read_bytes())
