"""What came of simulations of measured arms: the claim, errors against horizons, what was found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oed.commands.rollouts import BASE_OF_BODIES
from oed.report.table import Row, markdown_table

MODELS = {
    "file": "robot file",
    "base": "base",
    "base_bodies": BASE_OF_BODIES,
    "augmented": "augmented",
    "feasible": "feasible",
}
FIFTH = 0.2  # of the robot file's error that the claim allows


def page(rows: Sequence[Mapping[str, str]]) -> str:
    """What came out: the claim first, then errors against horizons, then what was found."""
    done = [row for row in rows if row["status"] == "done"]
    failed = [f"- {row['arm']}: {row['status']}" for row in rows if row["status"] != "done"]
    intro = (
        "Simulated from measured states under the measured torque of recordings that were not fitted: median "
        "distance of the flange from the measured one, in millimetres. **File**: the robot file's bodies alone. "
        "**Base**: rigid body, rotors, Coulomb and viscous friction by least squares; **augmented**: with what the "
        "diagnosis found. **In bodies**: the same, estimated with bodies that can exist. A model whose mass matrix "
        "is not positive definite has no simulation; one that is more than 10 rad off in a joint has left the arm."
    )
    lines = ["# Rollout on measured arms", "", intro, ""]
    lines += [f"- {verdict(row)}" for row in done]
    lines += ["", markdown_table([r for row in done for r in _errors(row)]), ""]
    lines += ["## What was found, and whether model.json holds it", ""]
    lines += [markdown_table([_found(row) for row in done]), "", *failed, ""]
    return "\n".join(lines)


def verdict(row: Mapping[str, str]) -> str:
    """The claim on one arm, in words."""
    ends = {m: _end(row, m) for m in MODELS}
    found, base, file = ends["feasible"], ends["base_bodies"], ends["file"]
    if found is None:
        return f"{row['arm']}: no simulation of the augmented model"
    words = [f"{row['arm']}: {found:.3g} mm after {row['horizons'].split()[-1]} s"]
    if file is None:
        words.append("the file's bodies have no simulation")
    else:
        kept = "kept" if found <= FIFTH * file else "not kept"
        words.append(f"{found / file:.2g} of the file's (at most {FIFTH:g}: {kept})")
    if base is not None:
        kept = "kept" if found <= base else "not kept"
        words.append(f"{found / base:.2g} of the base's in bodies (at most 1: {kept})")
    return ", ".join(words)


def _end(row: Mapping[str, str], model: str) -> float | None:
    told = row[f"flange_mm_{model}"].split()
    return float(told[-1]) if told else None


def _errors(row: Mapping[str, str]) -> list[Row]:
    found: list[Row] = []
    for m, name in MODELS.items():
        told = row[f"flange_mm_{m}"].split()
        cells = dict(zip(row["horizons"].split(), told, strict=False))
        joint = row[f"joint_{m}"].split("; ")[-1]
        found.append(
            {"arm": row["arm"], "model": name}
            | {f"{h} s [mm]": cells.get(h, "–") for h in row["horizons"].split()}
            | {"joints at the end [rad]": joint or row[f"not_simulated_{m}"]}
            | {"left the arm": f"{row[f'lost_{m}'] or '–'} of {row['windows']}"}
        )
    return found


def _found(row: Mapping[str, str]) -> Row:
    return {
        "arm": row["arm"],
        "named": row["named"] or "nothing",
        "without a name": row["unnamed"],
        "second round differs by": f"{float(row['second_round']):.1e}",
        "CPU [s]": row["seconds"],
    }
