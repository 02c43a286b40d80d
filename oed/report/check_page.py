"""The page that a checkup of a data set leaves: what is fine, what is not, what to record instead."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from oed.checkup.checkup import checkup_record
from oed.checkup.finding import Checkup, Finding, Level
from oed.counted import counted
from oed.experiment.dataset import DataSet
from oed.report.chart import THINNED, Chart
from oed.report.check_charts import range_chart, signal_charts
from oed.report.json_file import write_json
from oed.report.page import Command, Page, Section, Table, Text, Verdict, write_page
from oed.report.provenance import Provenance

COLOURS: dict[Level, Literal["good", "warning", "bad"]] = {
    "green": "good",
    "amber": "warning",
    "red": "bad",
}
HEADLINES: dict[Level, str] = {
    "green": "Nothing speaks against an estimate from these data.",
    "amber": "An estimate can be made; some things cost accuracy.",
    "red": "Mend this before trusting any estimate from these data.",
}
LONG = 12  # rows of a table
WORDS: dict[Level, str] = {"green": "fine", "amber": "costs accuracy", "red": "mend first"}


def write_check(
    checkup: Checkup,
    dataset: DataSet,
    out: Path,
    provenance: Provenance,
    *,
    motion: Mapping[str, object],
    command: str,
) -> None:
    """Leave check.json, the recorded motion and report.html in a folder.

    Args:
        checkup: To write down.
        dataset: That it is of.
        out: Folder, which exists.
        provenance: Of the run.
        motion: As `recorded_motion` gives it.
        command: That designs what completes the data.
    """
    write_json(out / "recorded_motion.json", motion)
    write_page(out / "report.html", _page(checkup, dataset, provenance, command))
    record = {
        **checkup_record(checkup),
        "command": command,
        "versions": provenance.versions,
        "commit": provenance.commit,
        "date": provenance.date,
    }
    write_json(out / "check.json", record)


def _page(checkup: Checkup, dataset: DataSet, provenance: Provenance, command: str) -> Page:
    notes = checkup.notes
    count = {level: sum(f.level == level for f in checkup.findings) for level in COLOURS}
    told = ", ".join(f"{count[level]} {word}" for level, word in WORDS.items() if count[level])
    return Page(
        title=f"Checkup of {checkup.name}",
        subtitle=f"{counted(len(dataset.recordings), 'recording')} of "
        f"{counted(dataset.robot.n, 'joint')}",
        verdict=Verdict(
            COLOURS[checkup.level],
            HEADLINES[checkup.level],
            (f"{_sentence(notes[0])} " if notes else "") + f"Of all that was looked at: {told}.",
        ),
        sections=(
            Section("What was looked at", [_box(finding) for finding in checkup.findings]),
            Section("What to record next", _next(checkup, command)),
            Section("Evidence", _evidence(checkup, dataset)),
            Section("The log", _signals(dataset)),
            Section(
                "Where it comes from",
                (
                    Text(f"Data: {dataset.source}. Licence: {dataset.licence}."),
                    Text(f"Commit {provenance.commit}, {provenance.date}."),
                ),
            ),
        ),
    )


def _box(finding: Finding) -> Verdict:
    headline = f"{_capital(finding.topic)}: {WORDS[finding.level]}"
    text = _sentence(finding.text)
    if finding.remedy:
        text += f" {_sentence(finding.remedy)}"
    return Verdict(COLOURS[finding.level], headline, text)


def _next(checkup: Checkup, command: str) -> tuple[Text | Command, ...]:
    first = (
        "First mend what is wrong with the log, then design a motion that completes it:"
        if checkup.cause is not None
        else "This designs the motion that adds most to what these recordings tell:"
    )
    return (Text(first), Command(command))


def _evidence(checkup: Checkup, dataset: DataSet) -> list[Table | Chart]:
    blocks: list[Table | Chart] = [range_chart(dataset)]
    # The longest last.
    tables = sorted((f for f in checkup.findings if f.rows), key=lambda f: len(f.rows) > LONG)
    blocks += [Table(f.rows, caption=f"{_capital(f.topic)}.", digits=3) for f in tables]
    return blocks


def _signals(dataset: DataSet) -> list[Text | Chart]:
    return [Text(THINNED), *signal_charts(dataset)]


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _sentence(text: str) -> str:
    return _capital(text.rstrip(".")) + "."
