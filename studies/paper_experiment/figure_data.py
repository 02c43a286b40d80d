"""What the figures of the paper's experiment draw, as rows of small tables."""

from __future__ import annotations

import numpy as np
from numpy import ndarray

from oed.report.table import Row
from oed.robot.builtin import imi_scara
from studies.paper_experiment import values as paper
from studies.paper_experiment.campaign import (
    JOINTS,
    SETS,
    Bench,
    CampaignConfig,
)
from studies.paper_experiment.designs import CRITERIA, NAMES, DesignConfig, DesignSet
from studies.paper_experiment.tables import Single, joint_response, table_rows

DRAWN_EVERY = 20  # [samples of 1 ms]: 50 points a second draw these slow motions smoothly
BODE_FREQUENCIES = np.geomspace(1.0, 1000.0, 200)  # [rad/s]


def bode(campaign: CampaignConfig, bench: Bench) -> list[Row]:
    """Closed-loop gain of both joints at least, typical and greatest inertia."""
    columns: dict[str, ndarray] = {"frequency": BODE_FREQUENCIES}
    for j, load in enumerate(campaign.laboratory.loads()):
        for name, inertia in (
            ("least", load.extremes[0]),
            ("typical", load.inertia),
            ("greatest", load.extremes[1]),
        ):
            response = joint_response(BODE_FREQUENCIES, bench, load, j, inertia)
            columns[f"gain_{j + 1}_{name}"] = 20 * np.log10(np.abs(response))
            columns[f"phase_{j + 1}_{name}"] = np.degrees(np.unwrap(np.angle(response)))
    return table_rows(columns)


def trajectories(designs: DesignSet, period: float) -> list[Row]:
    """Position, velocity and acceleration of every design, 50 points a second."""
    rows: list[Row] = []
    kept = slice(None, None, DRAWN_EVERY)
    for d, name in enumerate(NAMES):
        motion = designs.motion(d, period)[kept]
        columns = {"t": motion.t}
        for symbol, values in (("q", motion.q), ("dq", motion.dq), ("ddq", motion.ddq)):
            for j in range(JOINTS):
                columns[f"{symbol}_{j + 1}"] = values[:, j]
        rows += [{"design": name, **row} for row in table_rows(columns)]
    return rows


def generations(designs: DesignSet) -> list[Row]:
    """Best and mean fitness of each generation."""
    return [
        {
            "criterion": criterion,
            "generation": g,
            "best": float(designs.best[c, g]),
            "mean": float(designs.mean[c, g]),
            "best_so_far": float(designs.best_so_far[c, g]),
        }
        for c, criterion in enumerate(CRITERIA)
        for g in range(designs.best.shape[1])
    ]


def torques(single: Single, horizon: float) -> list[Row]:
    """Measured and predicted torque of the rich-friction experiments, row after row."""
    rows: list[Row] = []
    for criterion, experiment in zip(CRITERIA, single.rich, strict=True):
        for s, name in enumerate(SETS):
            measured, predicted = experiment.torque[s], experiment.predicted[s]
            count = len(measured)
            columns = {"sample": np.arange(count)}
            for j in range(JOINTS):
                columns[f"measured_{j + 1}"] = measured[:, j]
                columns[f"predicted_{j + 1}"] = predicted[:, j]
            rows += [
                {"design": criterion, "set": name, "horizon": horizon, **row}
                for row in table_rows(columns)
            ]
    return rows


def recursion(single: Single) -> list[Row]:
    """Recursive estimates of the rich-friction J_k experiment, and their deviations."""
    experiment = single.rich[0]
    columns: dict[str, ndarray] = {"sample": np.arange(1, len(experiment.recursion) + 1)}
    for p in range(len(paper.PARAMETERS)):
        columns[f"xi_{p + 1}"] = experiment.recursion[:, p]
        columns[f"std_{p + 1}"] = experiment.recursion_std[:, p]
    return table_rows(columns)


def designs(found: DesignSet) -> list[Row]:
    """Criteria and proven margin of every trajectory."""
    return [
        {
            "design": name,
            "J_k": float(found.J_k[d]),
            "J_d": float(found.J_d[d]),
            "margin": float(found.margin[d]),
        }
        for d, name in enumerate(NAMES)
    ]


def settings(config: DesignConfig, campaign: CampaignConfig, horizon: float) -> dict[str, object]:
    """What the figures' captions need to know."""
    limits = imi_scara().limits
    return {
        "horizon": horizon,
        "samples": config.samples,
        "repetitions": campaign.repetitions,
        "truth": campaign.laboratory.truth().tolist(),
        "parameters": [list(p) for p in paper.PARAMETERS],
        "position_limit": limits.position[:, 1].tolist(),
        "velocity_limit": limits.velocity[:, 1].tolist(),
        "acceleration_limit": limits.acceleration[:, 1].tolist(),
        "bandwidth": campaign.laboratory.specification.bandwidth,
        "peak_db": campaign.laboratory.specification.peak_db,
    }
