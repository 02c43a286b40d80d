"""What the figures read from a folder of results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy import ndarray

from oed.report.json_file import read_json
from oed.report.table import read_csv


def columns(file: Path) -> dict[str, ndarray]:
    """A CSV file by column."""
    rows = read_csv(file)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def settings(results: Path) -> dict[str, Any]:
    """Limits, truth and sizes of the experiment."""
    found = read_json(results / "figures" / "settings.json")
    assert isinstance(found, dict)
    return found


def by_joint(table: dict[str, ndarray], symbol: str, rows: ndarray) -> ndarray:
    """Columns symbol_1 and symbol_2 of some rows, (N, 2)."""
    return np.stack([table[f"{symbol}_{j}"][rows].astype(float) for j in (1, 2)], axis=1)


def trajectory(results: Path, design: str) -> tuple[ndarray, ndarray, ndarray, ndarray]:
    """Time (N,), position, velocity and acceleration (N, 2) of a design."""
    table = columns(results / "figures" / "trajectories.csv")
    mine = table["design"] == design
    q, dq, ddq = (by_joint(table, symbol, mine) for symbol in ("q", "dq", "ddq"))
    return table["t"][mine].astype(float), q, dq, ddq


def torque(results: Path, design: str, part: str) -> tuple[ndarray, ndarray, ndarray]:
    """Time in motion (N,), measured and predicted torque (N, 2) of a set of repetitions."""
    table = columns(results / "figures" / "torques.csv")
    mine = (table["design"] == design) & (table["set"] == part)
    given = settings(results)
    t = table["sample"][mine].astype(float) * given["horizon"] / given["samples"]
    return t, by_joint(table, "measured", mine), by_joint(table, "predicted", mine)


def mean_rms(results: Path, design: str, part: str) -> ndarray:
    """Rms residual of each joint, mean over all experiments of the table (2,) [N m]."""
    means = {
        row["quantity"]: row["mean of ours"]
        for row in read_csv(results / "comparison.csv")
        if row["design"] == design
    }
    return np.array([means[f"rms, {part} set, joint {j}"] for j in (1, 2)])


def of_design(results: Path, design: str) -> dict[str, Any]:
    """Criteria and proven margin of a design, and what is near or better."""
    rows = read_csv(results / "figures" / "designs.csv")
    return next(row for row in rows if row["design"] == design)


def parameter_symbol(name: str) -> str:
    """The paper's symbol for a parameter of the table, for a title."""
    symbols = {"Gamma": "Γ", "gamma": "γ", "s_2x": "s_{2x}", "s_2y": "s_{2y}"}
    for plain, symbol in {**symbols, "Γ_1z": "Γ_{1z}", "Γ_2z": "Γ_{2z}"}.items():
        name = name.replace(plain, symbol)
    for kind in ("s1", "s2", "v1", "v2"):
        name = name.replace(f"γ_{kind}", f"γ_{{{kind}}}")
    return f"${name}$"


def unit_symbol(unit: str) -> str:
    """A unit as it is printed."""
    return unit.replace("^2", "²")
