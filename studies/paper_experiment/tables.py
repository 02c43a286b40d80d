"""Tables of the paper's experiment: its numbers beside ours, and what was done, cell by cell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.experiment.control import JointLoad, bandwidth_and_peak, closed_loop_response
from oed.experiment.paper_signals import PAPER_FILTER
from oed.report.table import Cell, Row
from oed.robot.builtin import imi_scara
from studies.paper_experiment import values as paper
from studies.paper_experiment.campaign import WAYS, Campaign
from studies.paper_experiment.designs import CRITERIA, KINDS
from studies.paper_experiment.findings import (
    PAPER_FIT,
    RICHER_FIT,
    Finding,
    rms_relative,
)
from studies.paper_experiment.fitting import XI
from studies.paper_experiment.laboratory import FRICTIONS, JOINTS, Bench, LaboratoryConfig
from studies.paper_experiment.searches import HorizonTable, Searches

DIGITS = 4  # of a table's numbers: what the intervals carry, and more than rounding reaches
PERCENTILES = (2.5, 97.5)
ONLINE, RICH = WAYS.index("online"), FRICTIONS.index("rich")


def rounded(rows: Sequence[Row], digits: int = DIGITS) -> list[Row]:
    """Rows whose numbers have the digits that they carry: a rerun then writes the same."""
    return [{name: _rounded(value, digits) for name, value in row.items()} for row in rows]


def table_rows(columns: dict[str, ndarray]) -> list[Row]:
    """Columns of equal length as rows of plain numbers."""
    listed = [values.tolist() for values in columns.values()]
    return [dict(zip(columns, values, strict=True)) for values in zip(*listed, strict=True)]


def comparison(
    config: LaboratoryConfig, bench: Bench, searches: Searches, campaign: Campaign
) -> list[Row]:
    """Every number of the paper's sections 4 and 5 beside the range of ours.

    The range holds 95 % of single experiments over designs, test motions and noise, with rich
    friction and the paper's signals.
    """
    rows = [*_design_rows(searches), *_loop_rows(config, bench)]
    for k, criterion in enumerate(CRITERIA):
        rows += [
            _row(criterion, quantity, unit, published, drawn)
            for quantity, unit, published, drawn in _experiment_values(campaign, k)
        ]
    truth = config.laboratory.truth()
    for (name, unit), value, true in zip(paper.PARAMETERS, paper.MANUFACTURER, truth, strict=False):
        rows.append(_row("-", f"manufacturer's {name} (here: the truth)", unit, value, true))
    return rows


def _experiment_values(
    found: Campaign, k: int
) -> Iterator[tuple[str, str, float, Float[ndarray, "..."]]]:
    """Quantity, unit, the paper's value, and ours of every experiment."""
    own = (RICH, k, slice(None), slice(None), ONLINE)
    for j in range(JOINTS):
        yield f"sigma_{j + 1}^2", "N^2 m^2", paper.VARIANCES[k][j], found.variances[own][..., j]
    for p, (name, unit) in enumerate(paper.PARAMETERS):
        yield name, unit, paper.ESTIMATES[k][p], found.parameters[own][..., PAPER_FIT, p]
    for p, (name, unit) in enumerate(paper.PARAMETERS):
        values = found.covariance[own][..., PAPER_FIT, p, p]
        yield f"P of {name}", f"({unit})^2", paper.DIAGONAL_P[k][p], values
    test = (RICH, k, slice(None), slice(None), slice(None), ONLINE, PAPER_FIT)
    for s, name in enumerate(("estimation", "validation", "test")):
        for j in range(JOINTS):
            label = f"{name} set, joint {j + 1}"
            if name == "test":
                rms, relative = found.test_rms[test], found.test_relative[test]
            else:
                rms, relative = found.rms[own][..., s, :], found.relative[own][..., s, :]
            yield f"rms, {label}", "N m", paper.RMS[k][s][j], rms[..., j]
            share = 100 * paper.RELATIVE[k][s][j]
            yield f"relative rms, {label}", "%", share, 100 * relative[..., j]


def _row(
    design: str, quantity: str, unit: str, published: float, drawn: float | Float[ndarray, "..."]
) -> Row:
    low, high = np.percentile(drawn, PERCENTILES)
    return {
        "design": design,
        "quantity": quantity,
        "unit": unit,
        "paper": published,
        "mean of ours": float(np.mean(drawn)),
        "from": float(low),
        "to": float(high),
    }


def _design_rows(searches: Searches) -> list[Row]:
    limits = imi_scara().limits
    omega = min(
        limits.velocity[0, 1] / limits.position[0, 1],
        np.sqrt(limits.acceleration[0, 1] / limits.position[0, 1]),
    )
    J_k, J_d = searches.condition.best[:, -1], searches.determinant.best[:, -1]
    return [
        _row("-", "omega_max of (12d)", "rad/s", paper.OMEGA_MAX, omega),
        _row("J_k", "J_k = cond Lambda at the end", "-", paper.J_K, J_k),
        _row("J_d", "J_d = log10 det Lambda at the end", "-", paper.J_D, J_d),
        _row("J_d", "J_d with half of the instants", "-", paper.J_D, searches.half),
    ]


def _loop_rows(config: LaboratoryConfig, bench: Bench) -> list[Row]:
    cutoff = PAPER_FILTER.half_power_frequency()
    rows = [_row("-", "half power of the filter", "rad/s", paper.FILTER_CUTOFF, cutoff)]
    grid = np.geomspace(1.0, 2000.0, 4000)
    for j, load in enumerate(config.laboratory.loads()):
        bandwidth, _ = bandwidth_and_peak(grid, joint_response(grid, bench, load, j, load.inertia))
        peak = max(
            bandwidth_and_peak(grid, joint_response(grid, bench, load, j, m))[1]
            for m in load.extremes
        )
        rows.append(_row("-", f"bandwidth, joint {j + 1}", "rad/s", paper.BANDWIDTH, bandwidth))
        rows.append(_row("-", f"peak, joint {j + 1}", "dB", paper.PEAK_DB, peak))
    return rows


def joint_response(
    grid: Float[ndarray, " points"], bench: Bench, load: JointLoad, joint: int, inertia: float
) -> ndarray:
    """Closed-loop frequency response of one joint at an inertia."""
    controller = bench.controller
    return closed_loop_response(
        grid,
        inertia,
        load.viscous,
        controller.stiffness[joint],
        controller.damping[joint],
        controller.observer,
        joint,
        controller.period,
    )


def horizons(table: HorizonTable) -> list[Row]:
    """What the genetic algorithm reaches at each horizon: median and range over its seeds."""
    return [
        {
            "horizon": float(table.horizon[h]),
            "J_k median": float(np.median(table.J_k[h])),
            "J_k best": float(table.J_k[h].min()),
            "J_k worst": float(table.J_k[h].max()),
            "J_d median": float(np.median(table.J_d[h])),
            "J_d best": float(table.J_d[h].max()),
            "J_d at half the instants": float(np.median(table.J_d_half[h])),
        }
        for h in range(len(table.horizon))
    ]


def claims(findings: Sequence[Finding]) -> list[Row]:
    """Every finding, with its verdict and where its spread is from."""
    rows: list[Row] = []
    for f in findings:
        sources = f.sources
        rows.append(
            {
                "claim": f.claim.statement,
                "quantity": f.claim.quantity,
                "confirmed": f.claim.band,
                "refuted": f.claim.outside,
                "friction": f.friction,
                "signals": f.signals,
                "detail": f.detail,
                "value": f.interval.value,
                "lower": f.interval.lower,
                "upper": f.interval.upper,
                "unit": f.claim.unit,
                "verdict": f.verdict,
                "std, design pair": None if sources is None else sources.pair,
                "std, test motion": None if sources is None else sources.motion,
                "std, pair and motion": None if sources is None else sources.both,
                "std, noise": None if sources is None else sources.noise,
            }
        )
    return rows


def cells(found: Campaign, truth: Float[ndarray, "8"]) -> list[Row]:
    """One row a cell: friction, design, processing."""
    rows: list[Row] = []
    for f, k, w in np.ndindex(len(FRICTIONS), len(KINDS), len(WAYS)):
        xi = found.parameters[f, k, :, :, w, PAPER_FIT, :XI]
        mean = xi.mean(axis=1)
        bias, spread = mean - truth, (xi - mean[:, None]) * np.sqrt(xi.shape[1] / (xi.shape[1] - 1))
        row: dict[str, Cell] = {
            "friction": FRICTIONS[f],
            "design": KINDS[k],
            "signals": WAYS[w],
            "bias [%]": _percent(rms_relative(bias, truth)),
            "std [%]": _percent(rms_relative(spread, truth)),
        }
        test = found.test_relative[f, k, :, :, :, w]
        for j in range(JOINTS):
            row |= {
                f"residual {j + 1} [N m]": float(found.rms[f, k, :, :, w, 0, j].mean()),
                f"noise {j + 1} [N m]": float(np.sqrt(found.filtered[f, k, :, :, w, j].mean())),
                f"validation {j + 1} [%]": float(100 * found.relative[f, k, :, :, w, 1, j].mean()),
                f"test {j + 1} [%]": float(100 * test[..., PAPER_FIT, j].mean()),
                f"test {j + 1}, richer [%]": float(100 * test[..., RICHER_FIT, j].mean()),
            }
        rows.append(row)
    return rows


def _percent(errors: Float[ndarray, "..."]) -> float:
    return float(100 * np.sqrt((errors**2).mean()))


def _rounded(value: Cell, digits: int) -> Cell:
    value = value.item() if isinstance(value, np.generic) else value
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value
