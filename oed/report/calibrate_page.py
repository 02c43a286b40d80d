"""The page of a whole calibration: what was found, what bodies came out, where to look further."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from oed.report.joint_words import over_floor, place_words
from oed.report.page import Links, Page, Section, Table, Text, Verdict
from oed.report.provenance import Provenance
from oed.report.refinement_section import refinement_section
from oed.report.rollout_section import rollout_section

PAGES = (
    ("Base parameters", "identify/report.html", "with 95 % intervals, and their errors held out"),
    ("What the model lacks", "diagnosis/report.html", "effects found, and what they gain"),
    ("Bodies", "feasible/report.html", "masses and inertias that exist, beside what was found"),
)
WHOLE = "bodies, effects and measurement in one file"
LINKS = ("link", "file [kg]", "identified [kg]", "lower95 [kg]", "upper95 [kg]", "beyond reason")


def calibrate_page(record: Mapping[str, Any], provenance: Provenance) -> Page:
    """Put it together.

    Args:
        record: Of the calibration, as calibration.json has it.
        provenance: Of the run.
    """
    changes = record["changes_from_file"]
    bodies: list = (
        [Table(changes, "Masses beside the robot file's, and what moved beyond reason", LINKS)]
        if changes
        else []
    )
    bodies += [Text(f"Warning: {words}") for words in record["warnings"]]
    refined = record["refinement"] is not None and record["refinement"]["accepted"]
    model = "refined/model.json" if refined else "feasible/model.json"
    pages = (*PAGES, ("The model", model, WHOLE), *_exports(record["exports"]))
    return Page(
        f"Calibration of {record['data']}",
        _verdict(record),
        (
            Section("Where to look", (Links(pages),)),
            Section("What the model lacked", _errors(record)),
            *_rollout(record),
            *([refinement_section(record["refinement"])] if record["refinement"] else []),
            Section("Bodies", tuple(bodies or [Table(record["links"], "Links")])),
            Section("How it was made", (Text(f"Commit {provenance.commit}, {provenance.date}."),)),
        ),
    )


def _rollout(record: Mapping[str, Any]) -> tuple[Section, ...]:
    if record["rollout"] is None:
        return ()
    return (rollout_section(record["rollout"], tuple(record["joints"])),)


def _verdict(record: Mapping[str, Any]) -> Verdict:
    named = [f"{e['name']} ({place_words(e['joint'])})" for e in record["effects"]]
    found = f"Found: {', '.join(named)}." if named else "No effect was named."
    open_ones = f" {record['unexplained']} more without a name." if record["unexplained"] else ""
    if record["warnings"]:
        return Verdict("warning", "A model that runs, with warnings.", found + open_ones)
    return Verdict("good", "A model that runs, of bodies that exist.", found + open_ones)


def _errors(record: Mapping[str, Any]) -> tuple[Text | Table, ...]:
    """What has no name; errors before and after, in noise floors; the bodies' are on their page."""
    rms = record["rms"]
    rows = [
        {
            "recordings": role,
            "base model [noise floors]": over_floor(np.array(old), np.array(floor)),
            "with what was found [noise floors]": over_floor(np.array(new), np.array(floor)),
        }
        for role, old, new, floor in (
            (role, rms["before"][role], rms["after"][role], rms["noise_floor"][role])
            for role in rms["before"]
        )
    ]
    return (*_unnamed(record), Table(rows, "Torque error, root mean square over the joints"))


def _unnamed(record: Mapping[str, Any]) -> tuple[Text, ...]:
    """What was found without a name, in words."""
    if not record["without_name"]:
        return ()
    each = "; ".join(record["without_name"])
    return (
        Text(
            f"Without a name: {each}. The diagnosis page says how large it is, and what to do next."
        ),
    )


def _exports(exports: Mapping[str, Sequence[str]]) -> tuple[tuple[str, str, str], ...]:
    return tuple(
        (f"For {name}", f"export/{files[0]}", ", ".join(files)) for name, files in exports.items()
    )
