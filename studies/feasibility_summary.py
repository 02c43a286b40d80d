"""Rows of the study of feasibility's price as a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from oed.report.table import Row, markdown_table

Line = Mapping[str, str]


def summarise(rows: Sequence[Line], repeats: int, poses: int) -> str:
    """Medians over draws as a page.

    Args:
        rows: Of the study.
        repeats: Draws of each case.
        poses: At which mass matrices were examined.
    """
    return (
        "# What physical constraints cost and buy\n\n"
        "Six-joint elbow arm with known parameters; every number is the median over "
        f"{repeats} draws of motion, noise and prior. `condition`: of the regressor with unit "
        "columns. `estimation`: rms residual per noise deviation, of the data that were fitted. "
        "`validation`: relative rms error of the noise-free torque on another, good motion. "
        "`parameters`: relative error of the base parameters, each in the torque that it makes. "
        f"`PD`: least share of {poses} poses with a positive definite mass matrix. "
        "`robot`: share of draws whose base parameters some feasible robot has.\n\n"
        + markdown_table(_medians(rows), digits=3)
    )


def _medians(rows: Sequence[Line]) -> list[Row]:
    groups: dict[tuple[str, ...], list[Line]] = {}
    for row in rows:
        key = tuple(row[k] for k in ("excitation", "noise", "samples", "estimator"))
        groups.setdefault(key, []).append(row)
    table: list[Row] = []
    for (excitation, noise, samples, estimator), group in groups.items():
        solved = [row for row in group if row["status"] == "done"]

        def median(column: str, solved: list[Line] = solved) -> float:
            values = [float(row[column]) for row in solved]
            return float(np.median(values)) if values else np.nan

        table.append(
            {
                "excitation": excitation,
                "noise": float(noise),
                "samples": int(samples),
                "estimator": estimator,
                "condition": median("condition"),
                "estimation": median("estimation_rms"),
                "validation": median("validation_error"),
                "parameters": median("parameter_error"),
                "PD": min((float(row["positive_definite"]) for row in solved), default=np.nan),
                "robot": float(
                    np.mean([row["feasible_robot"] == "True" for row in solved] or [np.nan])
                ),
                "seconds": median("seconds"),
                "failed": len(group) - len(solved),
            }
        )
    return table
