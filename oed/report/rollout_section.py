"""Rollouts on a page: how far each model's simulation is from the arm, after each horizon."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from oed.report.chart import BOTTOM, COLOURS, TOP, Chart
from oed.report.page import Section, Table, Text
from oed.report.table import Row

TITLE = "Whether a simulation moves like the arm"
HEIGHT = 320  # [px] of the plot
EXPLAINED = (
    "Simulated from measured states under the measured torque, on recordings that were not fitted; "
    "median over {windows} windows. A delay or gain that was found is taken off the torque. "
    "One that is more than 10 rad or m off in a joint has left the arm."
)


def rollout_section(record: Mapping[str, Any], joints: tuple[str, ...]) -> Section:
    """A picture and two tables.

    Args:
        record: As calibration.json has it: horizons, and each model's errors.
        joints: Names.
    """
    horizons, every = record["horizons"], record["models"]
    models = {name: told for name, told in every.items() if told["not_simulated"] is None}
    without = [
        Text(f"Not simulated, {name}: {told['not_simulated']}.")
        for name, told in every.items()
        if told["not_simulated"] is not None
    ]
    if not models:
        return Section(TITLE, tuple(without))
    windows = max(told["windows"] for told in models.values())
    flange: list[Row] = [
        {"model": name}
        | {f"{h:g} s [mm]": e for h, e in zip(horizons, told["flange_mm"], strict=True)}
        | {"left the arm": told["lost"]}
        for name, told in models.items()
    ]
    by_joint: list[Row] = [
        {"joint": joint} | {f"{name} [rad]": told["joint"][-1][j] for name, told in models.items()}
        for j, joint in enumerate(joints)
    ]
    return Section(
        TITLE,
        (
            Text(EXPLAINED.format(windows=windows)),
            *without,
            _chart(horizons, models),
            Table(flange, "Error at the last link's origin"),
            Table(by_joint, f"Error of each joint after {horizons[-1]:g} s"),
        ),
    )


def _chart(horizons: list[float], models: Mapping[str, Any]) -> Chart:
    traces = [
        {
            "type": "scatter",
            "mode": "lines+markers",
            "name": name,
            "x": np.array(horizons, dtype=float),
            "y": np.array(told["flange_mm"], dtype=float),
            "line": {"color": colour},
        }
        for (name, told), colour in zip(models.items(), COLOURS, strict=False)
    ]
    axes = {
        "xaxis": {"title": {"text": "horizon [s]"}, "type": "log", "tickvals": list(horizons)},
        "yaxis": {"title": {"text": "error at the last link [mm]"}, "type": "log"},
    }
    caption = "Distance between the simulated and the measured last link, after each horizon."
    return Chart(traces, axes, caption, TOP + BOTTOM + HEIGHT)
