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


def trajectory(results: Path, design: str) -> tuple[ndarray, ndarray, ndarray, ndarray]:
    """Time (N,), position, velocity and acceleration (N, 2) of a design."""
    table = columns(results / "figures" / "trajectories.csv")
    mine = table["design"] == design
    signals = (
        np.stack([table[f"{symbol}_{j}"][mine].astype(float) for j in (1, 2)], axis=1)
        for symbol in ("q", "dq", "ddq")
    )
    q, dq, ddq = signals
    return table["t"][mine].astype(float), q, dq, ddq


def torque(results: Path, design: str, part: str) -> tuple[ndarray, ndarray, ndarray]:
    """Time in motion (N,), measured and predicted torque (N, 2) of a set of repetitions."""
    table = columns(results / "figures" / "torques.csv")
    mine = (table["design"] == design) & (table["set"] == part)
    given = settings(results)
    t = table["sample"][mine].astype(float) * given["horizon"] / given["samples"]
    measured, predicted = (
        np.stack([table[f"{kind}_{j}"][mine].astype(float) for j in (1, 2)], axis=1)
        for kind in ("measured", "predicted")
    )
    return t, measured, predicted


def design_value(results: Path, design: str, criterion: str) -> float:
    """J_k or J_d of a design."""
    rows = read_csv(results / "figures" / "designs.csv")
    value = next(row[criterion] for row in rows if row["design"] == design)
    assert isinstance(value, int | float)
    return float(value)


def reproduced(results: Path, design: str, quantity: str) -> float:
    """A number of the comparison table, as reproduced."""
    return _compared(results, design, quantity, "reproduced")


def published(results: Path, design: str, quantity: str) -> float:
    """A number of the comparison table, as the paper states it."""
    return _compared(results, design, quantity, "paper")


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


def _compared(results: Path, design: str, quantity: str, column: str) -> float:
    rows = read_csv(results / "comparison.csv")
    found = [r for r in rows if r["design"] == design and str(r["quantity"]).startswith(quantity)]
    value = found[0][column]
    assert isinstance(value, int | float)
    return float(value)
