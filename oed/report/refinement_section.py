"""A refinement by rollout on a page: what it came to, and how far it is from inverse dynamics."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from oed.report.page import Section, Table, Text
from oed.report.table import Row


def refinement_section(record: Mapping[str, Any]) -> Section:
    """Whether it is accepted, errors held out before and after, and what the gap says.

    Args:
        record: As calibration.json has it.
    """
    judged = (
        "Accepted: the exports have the refined parameters."
        if record["accepted"]
        else f"Not accepted, the model stays as it was: {record['reason']}."
    )
    rows: list[Row] = [
        {"recordings": told["role"], "torque error, over that before": told["torque_ratio"]}
        | {
            f"{h:g} s [mm]": f"{old:.3g} → {new:.3g}"
            for h, old, new in zip(
                told["horizons"], told["flange_mm_before"], told["flange_mm_after"], strict=True
            )
        }
        for told in record["errors"]
    ]
    table = (Table(rows, "Errors held out; of the last link's origin before → after"),)
    return Section("Refined by rollout", (Text(judged), *(table if rows else ()), *_gap(record)))


def _gap(record: Mapping[str, Any]) -> tuple[Text, ...]:
    if record.get("distance") is None:
        return ()
    distance, allowed = record["distance"], record["allowed"]
    says = (
        "No more than noise makes. That does not show that the class of model is right: the estimate by "
        "inverse dynamics is the prior here and holds this fit near it, the more so the less these windows "
        "tell; a term that is missing can stay unseen."
        if distance <= allowed
        else "More than noise makes: the class of model is wrong, something that moves the arm is missing in it."
    )
    return (
        Text(
            f"Parameters that fit {record['windows']} simulated windows of half a second are {distance:.3g} "
            f"from those of inverse dynamics (squared, in standard deviations, {record['directions']} "
            f"directions; with the right model below {allowed:.3g} in 95 % of cases or more). {says} "
            f"The solver says: {record['status']}."
        ),
    )
