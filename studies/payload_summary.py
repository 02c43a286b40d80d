"""What the loads of `studies.payload` show, as a page."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import binom

from oed.report.table import Row, markdown_table

GROUPS = {"mass": slice(0, 1), "centre": slice(1, 4), "inertia": slice(4, 10)}
LEVEL = 0.95
RANDOM = {"3 s": 3.0, "usual": 10.0, "20 s": 20.0}  # [s] of random motion
DESIGNED = ("3 s, designed", "6 s, designed")
LONG = "20 s"
RowOf = dict[str, str]


def page(rows: Sequence[RowOf]) -> str:
    """The rows as a page."""
    good = [row for row in rows if row["status"] == "ok"]
    failed = len(rows) - len(good)
    usual = [row for row in good if row["cell"] == "usual"] or good
    return (
        "# Loads, weighed\n\n"
        f"{len(good)} loads of 0.1 to 5 kg, {failed} more failed. Torques by Drake, with undeclared Stribeck "
        "friction (10 to 40 % of Coulomb friction), friction that grows with the load (2 to 12 % of what "
        "a gear carries), friction that changes by 10 % from the bare day to the loaded one, white noise in "
        "half of the cases and coloured in the other, encoders of 18 bits. `usual`: 30 s of the bare "
        "arm, 10 s with the load, both random motions.\n\n"
        "## How often 95 % intervals hold the truth\n\n"
        "Share of intervals that hold it; `bounds` are what chance allows at 95 % for one that is right. "
        "The centre has three numbers a load and inertia six, which are not independent.\n\n"
        + markdown_table(_coverage(usual), digits=3)
        + "\n## What decides how well a load is known\n\n"
        "Medians over loads: half width of the interval and error of the mass, as shares of it; distance of "
        "the centre of mass from the true one and the widest half width of its coordinates [mm]; widest "
        "half width of the inertia [kg m^2]. `feasible`: all bodies can exist. `offsets drift`: between the days "
        "each joint's torque drifts by 5 % of its Coulomb friction, which the model has not, or has.\n\n"
        + markdown_table(_cells(good), digits=3)
        + "\n## A short motion against a long one\n\n"
        "Medians over the loads that all of these cells weigh, the same on the same arms: half width of the "
        "mass's interval, and that over the half width by 20 s of random motion. `as long as`: of a "
        "random motion as narrow, between the lengths here.\n\n"
        + markdown_table(_lengths(good), digits=3)
        + "\n## Friction that grows with the load\n\n"
        "The same data by a model without it: how far off the mass is, and how often its interval holds the "
        "truth.\n\n" + markdown_table(_friction(usual), digits=3)
    )


def _coverage(rows: Sequence[RowOf]) -> list[Row]:
    found: list[Row] = []
    for arm in dict.fromkeys(row["arm"] for row in rows):
        own = [row for row in rows if row["arm"] == arm]
        low, high = binom.interval(LEVEL, len(own), LEVEL)
        shares = {name: _share(own, group) for name, group in GROUPS.items()}
        bounds = f"{low / len(own):.3g} to {high / len(own):.3g}"
        found.append({"arm": arm, "loads": len(own), **shares, "bounds, one number": bounds})
    return found


def _share(rows: Sequence[RowOf], group: slice) -> float:
    """Of the intervals that are claimed."""
    letters = "".join(row["held"][1:][group] for row in rows)
    claimed = letters.replace("-", "")
    return claimed.count("1") / len(claimed) if claimed else float("nan")


def _cells(rows: Sequence[RowOf]) -> list[Row]:
    found: list[Row] = []
    for arm in dict.fromkeys(row["arm"] for row in rows):
        for cell in dict.fromkeys(row["cell"] for row in rows):
            own = [row for row in rows if (row["arm"], row["cell"]) == (arm, cell)]
            if own:
                found.append({"arm": arm, "cell": cell, "loads": len(own), **_medians(own)})
    return found


def _medians(rows: Sequence[RowOf]) -> Row:
    def median(column: str, factor: float = 1.0) -> float:
        values = np.array([float(row[column]) for row in rows])
        return factor * float(np.nanmedian(np.abs(values))) if np.isfinite(values).any() else np.nan

    return {
        "mass held": _share(rows, GROUPS["mass"]),
        "mass half": median("mass_half"),
        "mass error": median("mass_error"),
        "centre off [mm]": median("centre_error", 1e3),
        "centre half [mm]": median("centre_half", 1e3),
        "inertia half": median("inertia_half"),
        "feasible": all(float(row["margin"]) > 0 for row in rows),
        "CPU s": median("seconds"),
    }


def _lengths(rows: Sequence[RowOf]) -> list[Row]:
    """Every cell that differs from another by its motion alone, beside 20 s."""
    found: list[Row] = []
    for arm in dict.fromkeys(row["arm"] for row in rows):
        half = {
            cell: {
                row["number"]: float(row["mass_half"]) * float(row["mass"])
                for row in rows
                if (row["arm"], row["cell"]) == (arm, cell)
            }
            for cell in (*RANDOM, *DESIGNED)
        }
        common = set.intersection(*(set(own) for own in half.values()))
        if not common:
            continue
        over = {
            cell: float(np.median([own[k] / half[LONG][k] for k in common]))
            for cell, own in half.items()
        }
        for cell, own in half.items():
            found.append(
                {
                    "arm": arm,
                    "cell": cell,
                    "loads": len(common),
                    "mass half [kg]": float(np.median([own[k] for k in common])),
                    "over 20 s": over[cell],
                    "as long as [s]": _length(over, cell),
                }
            )
    return found


def _length(over: dict[str, float], cell: str) -> float:
    """Of a random motion as narrow, interpolated in logarithms; at the ends of what was tried."""
    seconds = np.array(sorted(RANDOM.values()))
    widths = np.array([over[name] for name in sorted(RANDOM, key=lambda name: RANDOM[name])])
    return float(np.exp(np.interp(-np.log(over[cell]), -np.log(widths), np.log(seconds))))


def _friction(rows: Sequence[RowOf]) -> list[Row]:
    found: list[Row] = []
    rows = [row for row in rows if row["held_without"]]
    for arm in dict.fromkeys(row["arm"] for row in rows):
        own = [row for row in rows if row["arm"] == arm]
        errors = {
            name: np.array([float(row[column]) * float(row["mass"]) for row in own])
            for name, column in (("with it", "mass_error"), ("without", "mass_error_without"))
        }
        row: dict[str, str | float] = {"arm": arm}
        for name, values in errors.items():
            row[f"rms error {name} [kg]"] = float(np.sqrt(np.mean(values**2)))
        row["held with it"] = _share(own, GROUPS["mass"])
        row["held without"] = float(np.mean([row["held_without"] == "1" for row in own]))
        found.append(row)
    return found
