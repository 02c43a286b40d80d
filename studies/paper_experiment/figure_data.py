"""What the figures of the paper's experiment draw, as rows of small tables."""

from __future__ import annotations

import numpy as np
from numpy import ndarray

from oed.report.table import Row
from oed.robot.builtin import imi_scara
from studies.paper_experiment import values as paper
from studies.paper_experiment.config import Config
from studies.paper_experiment.designs import CRITERIA
from studies.paper_experiment.laboratory import JOINTS, Bench, LaboratoryConfig
from studies.paper_experiment.stages import Result
from studies.paper_experiment.tables import joint_response, table_rows

DIGITS = 5  # of what is drawn
DRAWN_EVERY = 20  # [samples of 1 ms]: 50 points a second draw these slow motions smoothly
BODE_FREQUENCIES = np.geomspace(1.0, 1000.0, 200)  # [rad/s]
SETS = ("estimation", "validation", "test")


def bode(config: LaboratoryConfig, bench: Bench) -> list[Row]:
    """Closed-loop gain of both joints at least, typical and greatest inertia."""
    columns: dict[str, ndarray] = {"frequency": BODE_FREQUENCIES}
    for j, load in enumerate(config.laboratory.loads()):
        for name, inertia in (
            ("least", load.extremes[0]),
            ("typical", load.inertia),
            ("greatest", load.extremes[1]),
        ):
            response = joint_response(BODE_FREQUENCIES, bench, load, j, inertia)
            columns[f"gain_{j + 1}_{name}"] = 20 * np.log10(np.abs(response))
            columns[f"phase_{j + 1}_{name}"] = np.degrees(np.unwrap(np.angle(response)))
    return table_rows(columns)


def trajectories(found: Result) -> list[Row]:
    """Position, velocity and acceleration of what is shown, 50 points a second."""
    rows: list[Row] = []
    kept = slice(None, None, DRAWN_EVERY)
    for name, whole in zip((*CRITERIA, "test"), found.shown_references, strict=True):
        motion = whole[kept]
        columns = {"t": motion.t}
        for symbol, values in (("q", motion.q), ("dq", motion.dq), ("ddq", motion.ddq)):
            for j in range(JOINTS):
                columns[f"{symbol}_{j + 1}"] = values[:, j]
        rows += [{"design": name, **row} for row in table_rows(columns)]
    return rows


def designs(found: Result) -> list[Row]:
    """Criteria and proven margin of the designs that are shown, and what is near or better."""
    return [
        {
            "design": criterion,
            "J_k": float(found.designs.J_k[k, run]),
            "J_d": float(found.designs.J_d[k, run]),
            "margin": round(float(found.designs.margin[k, run]), 6),  # further digits are rounding
            "best of a bit's change": float(found.designs.neighbours[k]),
            "best of all seeds": best,
        }
        for k, (criterion, run, best) in enumerate(
            zip(
                CRITERIA,
                found.designs.shown,
                (
                    float(found.searches.condition.best[:, -1].min()),
                    float(found.searches.determinant.best[:, -1].max()),
                ),
                strict=True,
            )
        )
    ]


def generations(found: Result) -> list[Row]:
    """Best and mean fitness of each generation of the runs that are shown."""
    rows: list[Row] = []
    searches = (found.searches.condition, found.searches.determinant)
    for criterion, search, run in zip(CRITERIA, searches, found.designs.shown, strict=True):
        columns = {
            "generation": np.arange(search.generations + 1),
            "best": search.best[run],
            "mean": search.mean[run],
        }
        rows += [{"criterion": criterion, **row} for row in table_rows(columns)]
    return rows


def torques(found: Result) -> list[Row]:
    """Measured and predicted torque of what is shown, row after row."""
    rows: list[Row] = []
    for criterion, shown in zip(CRITERIA, found.shown, strict=True):
        for s, name in enumerate(SETS):
            columns = {"sample": np.arange(shown.torque.shape[1])}
            for j in range(JOINTS):
                columns[f"measured_{j + 1}"] = shown.torque[s, :, j]
                columns[f"predicted_{j + 1}"] = shown.predicted[s, :, j]
            rows += [{"design": criterion, "set": name, **row} for row in table_rows(columns)]
    return rows


def recursion(found: Result) -> list[Row]:
    """Recursive estimates of the J_k experiment that is shown, and their deviations."""
    shown = found.shown[0]
    columns: dict[str, ndarray] = {"sample": np.arange(1, len(shown.recursion) + 1)}
    for p in range(len(paper.PARAMETERS)):
        columns[f"xi_{p + 1}"] = shown.recursion[:, p]
        columns[f"std_{p + 1}"] = shown.recursion_std[:, p]
    return table_rows(columns)


def settings(config: Config, found: Result) -> dict[str, object]:
    """What the figures' captions need to know."""
    limits = imi_scara().limits
    laboratory = config.laboratory.laboratory
    return {
        "horizon": float(found.horizons.chosen),
        "samples": config.laboratory.samples,
        "repetitions": config.laboratory.repetitions,
        "truth": laboratory.truth().tolist(),
        "parameters": [list(p) for p in paper.PARAMETERS],
        "paper": {"J_k": paper.J_K, "J_d": paper.J_D},
        "position_limit": limits.position[:, 1].tolist(),
        "velocity_limit": limits.velocity[:, 1].tolist(),
        "acceleration_limit": limits.acceleration[:, 1].tolist(),
        "bandwidth": laboratory.specification.bandwidth,
        "peak_db": laboratory.specification.peak_db,
    }
