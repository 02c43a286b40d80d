"""Rows of the paper's experiment: its numbers beside ours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.experiment.control import JointLoad, bandwidth_and_peak, closed_loop_response
from oed.experiment.paper_signals import PAPER_FILTER
from oed.report.table import Cell, Row
from oed.robot.builtin import imi_scara
from studies.paper_experiment import values as paper
from studies.paper_experiment.campaign import (
    FRICTIONS,
    JOINTS,
    SETS,
    Bench,
    CampaignConfig,
    EnergyComparison,
    Experiment,
    ProcessingComparison,
    controller_of,
)
from studies.paper_experiment.designs import CRITERIA, NAMES, DesignConfig, DesignSet, HorizonTable
from studies.paper_experiment.monte_carlo import DESIGNS, MonteCarlo


@dataclass(frozen=True)
class Single:
    """The displayed experiments: friction by design, in the order J_k, J_d of the GA."""

    plain: tuple[Experiment, Experiment]
    rich: tuple[Experiment, Experiment]

    def of(self, friction: str) -> tuple[Experiment, Experiment]:
        """Those of one friction."""
        return self.plain if friction == "plain" else self.rich


def comparison(
    config: DesignConfig,
    campaign: CampaignConfig,
    designs: DesignSet,
    bench: Bench,
    single: Single,
) -> list[Row]:
    """Every number of the paper's section 4 and 5 beside the one reproduced."""
    rows = _design_rows(config, designs) + _loop_rows(campaign, bench)
    for d, criterion in enumerate(CRITERIA):
        pair = [single.of(friction)[d] for friction in FRICTIONS]
        for j in range(JOINTS):
            values = [e.variances[j] for e in pair]
            rows.append(
                _row(criterion, f"sigma_{j + 1}^2", "N^2 m^2", paper.VARIANCES[d][j], *values)
            )
        for p, (name, unit) in enumerate(paper.PARAMETERS):
            values = [e.parameters[p] for e in pair]
            rows.append(_row(criterion, name, unit, paper.ESTIMATES[d][p], *values))
        for p, (name, unit) in enumerate(paper.PARAMETERS):
            values = [e.covariance[p, p] for e in pair]
            rows.append(
                _row(criterion, f"P of {name}", f"({unit})^2", paper.DIAGONAL_P[d][p], *values)
            )
        for s, name in enumerate(SETS):
            for j in range(JOINTS):
                rms = [e.rms[s, j] for e in pair]
                relative = [100 * e.relative[s, j] for e in pair]
                label = f"{name} set, joint {j + 1}"
                rows.append(_row(criterion, f"rms, {label}", "N m", paper.RMS[d][s][j], *rms))
                rows.append(
                    _row(
                        criterion,
                        f"relative rms, {label}",
                        "%",
                        100 * paper.RELATIVE[d][s][j],
                        *relative,
                    )
                )
    truth = campaign.laboratory.truth()
    for p, value in enumerate(paper.MANUFACTURER):
        name, unit = paper.PARAMETERS[p]
        rows.append(
            _row("-", f"manufacturer's {name} (here: the truth)", unit, value, truth[p], truth[p])
        )
    return rows


def _row(  # noqa: PLR0917  # reads as the row that it makes
    design: str, quantity: str, unit: str, published: float, plain: float, rich: float
) -> Row:
    return {
        "design": design,
        "quantity": quantity,
        "unit": unit,
        "paper": published,
        "reproduced": float(rich),
        "with the paper's friction": float(plain),
    }


def _design_rows(config: DesignConfig, designs: DesignSet) -> list[Row]:
    J_k, J_d = float(designs.J_k[0]), float(designs.J_d[1])
    best = designs.best_so_far[0]
    reached = float(np.argmax(best <= 1.05 * best[-1]))
    limits = imi_scara().limits
    omega = float(
        min(
            limits.velocity[0, 1] / limits.position[0, 1],
            np.sqrt(limits.acceleration[0, 1] / limits.position[0, 1]),
        )
    )
    variables = 2 * config.terms * JOINTS
    bits = variables * config.bits
    return [
        _row("-", "omega_max of (12d)", "rad/s", paper.OMEGA_MAX, omega, omega),
        _row("-", "decision variables", "-", 12, variables, variables),
        _row("-", "bits of a genotype", "-", 48, bits, bits),
        _row("J_k", "J_k = cond Lambda, best of the GA", "-", paper.J_K, J_k, J_k),
        _row("J_k", "generations until within 5 %", "-", paper.GENERATIONS, reached, reached),
        _row("J_d", "J_d = log10 det Lambda, best of the GA", "-", paper.J_D, J_d, J_d),
        _row("J_d", "det Lambda", "-", paper.DETERMINANT, 10**J_d, 10**J_d),
    ]


def _loop_rows(campaign: CampaignConfig, bench: Bench) -> list[Row]:
    rows = []
    cutoff = PAPER_FILTER.half_power_frequency()
    rows.append(_row("-", "half power of the filter", "rad/s", paper.FILTER_CUTOFF, cutoff, cutoff))
    grid = np.geomspace(1.0, 2000.0, 4000)
    for j, load in enumerate(campaign.laboratory.loads()):
        bandwidth, _ = bandwidth_and_peak(grid, joint_response(grid, bench, load, j, load.inertia))
        peak = max(
            bandwidth_and_peak(grid, joint_response(grid, bench, load, j, m))[1]
            for m in load.extremes
        )
        rows.append(
            _row("-", f"bandwidth, joint {j + 1}", "rad/s", paper.BANDWIDTH, bandwidth, bandwidth)
        )
        rows.append(_row("-", f"peak, joint {j + 1}", "dB", paper.PEAK_DB, peak, peak))
    return rows


def joint_response(
    grid: Float[ndarray, " points"],
    bench: Bench,
    load: JointLoad,
    joint: int,
    inertia: float,
) -> ndarray:
    """Closed-loop frequency response of one joint at an inertia."""
    controller = controller_of(bench)
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


def terms(table: HorizonTable) -> list[Row]:
    """J_k by the number of sines, at the chosen horizon: median and range over the seeds."""
    return [
        {
            "sines W": int(table.terms[k]),
            "J_k median": float(np.median(table.J_k_by_terms[k])),
            "J_k best": float(table.J_k_by_terms[k].min()),
            "J_k worst": float(table.J_k_by_terms[k].max()),
        }
        for k in np.argsort(table.terms)
    ]


def processing(
    comparisons: dict[tuple[str, str], ProcessingComparison], truth: Float[ndarray, "8"]
) -> list[Row]:
    """Bias and spread of the parameters, and residuals, by processing."""
    rows: list[Row] = []
    for (design, friction), found in comparisons.items():
        for w, way in enumerate(found.ways):
            estimates = found.parameters[w]
            rows.append(
                {
                    "design": design,
                    "friction": friction,
                    "processing": str(way),
                    "rms bias [% of truth]": _rms_percent(estimates.mean(axis=0) - truth, truth),
                    "rms std [% of truth]": _rms_percent(estimates.std(axis=0, ddof=1), truth),
                    **{
                        f"rms residual {j + 1} [N m]": float(found.rms[w, :, j].mean())
                        for j in range(JOINTS)
                    },
                    **{
                        f"noise floor {j + 1} [N m]": float(np.sqrt(found.variances[w, j]))
                        for j in range(JOINTS)
                    },
                }
            )
    return rows


def energy(
    comparisons: dict[tuple[str, str], EnergyComparison], truth: Float[ndarray, "8"]
) -> list[Row]:
    """Each parameter by Newton-Euler and by energy: mean, spread and whether they agree."""
    rows: list[Row] = []
    for (friction, way), found in comparisons.items():
        for p, (name, unit) in enumerate(paper.PARAMETERS):
            torque, work = found.torque[:, p], found.energy[:, p]
            spread = float(np.hypot(torque.std(ddof=1), work.std(ddof=1)))
            rows.append(
                {
                    "friction": friction,
                    "processing": way,
                    "parameter": name,
                    "unit": unit,
                    "truth": float(truth[p]),
                    "Newton-Euler": float(torque.mean()),
                    "its std": float(torque.std(ddof=1)),
                    "energy": float(work.mean()),
                    "std of energy": float(work.std(ddof=1)),
                    "agree": bool(abs(torque.mean() - work.mean()) < 1.96 * spread),
                }
            )
    return rows


def monte_carlo(runs: MonteCarlo, truth: Float[ndarray, "8"]) -> list[Row]:
    """One row a cell: friction, design, processing."""
    rows: list[Row] = []
    for f, friction in enumerate(FRICTIONS):
        for d in DESIGNS:
            for r, way in enumerate(runs.processings.tolist()):
                estimates = runs.parameters[f, d, r]
                row: dict[str, Cell] = {
                    "friction": friction,
                    "design": NAMES[d],
                    "processing": way,
                    "experiments": len(estimates),
                    "rms bias [% of truth]": _rms_percent(estimates.mean(axis=0) - truth, truth),
                    "rms std [% of truth]": _rms_percent(estimates.std(axis=0, ddof=1), truth),
                }
                for j in range(JOINTS):
                    row[f"variance {j + 1} [N^2 m^2]"] = float(runs.variances[f, d, r, :, j].mean())
                for s, name in enumerate(SETS):
                    for j in range(JOINTS):
                        row[f"rms {name} {j + 1} [N m]"] = float(runs.rms[f, d, r, :, s, j].mean())
                        row[f"relative {name} {j + 1} [%]"] = float(
                            100 * runs.relative[f, d, r, :, s, j].mean()
                        )
                rows.append(row)
    return rows


def table_rows(columns: dict[str, ndarray]) -> list[Row]:
    """Columns of equal length as rows of plain numbers, to six digits: enough to draw."""
    names = list(columns)
    listed = [
        [float(f"{x:.6g}") if isinstance(x, float) else x for x in values.tolist()]
        for values in columns.values()
    ]
    return [dict(zip(names, values, strict=True)) for values in zip(*listed, strict=True)]


def _rms_percent(error: Float[ndarray, "8"], truth: Float[ndarray, "8"]) -> float:
    return float(100 * np.sqrt(np.mean((error / truth) ** 2)))
