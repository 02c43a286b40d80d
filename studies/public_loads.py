"""Is a load that was put on a scale weighed right by a real arm, from its motor currents?

    python -m studies.public_loads --repo DIR [DIR …] [--out results/public_loads] [--smoke]

Recordings of a UR10e with and without a load of 2.805 kg, published with the code of a study of
collision detection (Frontiers in Robotics and AI 2020, 571574; github.com/shamilmamedov/dynamic_calibration, which
states no licence: nothing of it is kept here).
One pair of recordings and the known mass give the motors' gains (`oed gains`); with these, `oed payload`
weighs the load in recordings of other motions, three weeks earlier, as if it were unknown. The claim
is refuted by a mass that is more than 2 per cent off, or outside its interval. The gains that are published with the recordings
weigh beside them.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.commands.configurations import Gains, Payload
from oed.commands.gains import measure
from oed.commands.options import parse
from oed.commands.payload import weigh
from oed.commands.telling import speak
from oed.errors import OedError
from oed.experiment.importing.import_log import ImportChoices, propose_import
from oed.experiment.importing.write_import import write_import
from oed.process_end import leave
from oed.report.json_file import write_atomically
from oed.report.provenance import Provenance
from oed.report.table import Row, markdown_table, write_csv
from studies.public_arms.clones import clone_of, commit_of
from studies.study_options import StudyOptions

REPOSITORY = "shamilmamedov/dynamic_calibration"
LOGS = Path("dataset_ur10e/identification_data")
ROBOT = Path("URe/urdf/ur10e.urdf")
MASS = 2.805  # [kg], estimate_drive_gains.m
PUBLISHED = (14.87, 13.26, 11.13, 10.62, 11.03, 11.47)  # [N m/A], main.m
JOINTS = 6
MOST_OFF = 2.0  # [%]
OURS = "ours"
COLUMNS = 1 + 5 * JOINTS  # time, position, velocity, current, and two that the controller wanted


@dataclass(frozen=True)
class Pair:
    """Recordings without and with the load.

    Attributes:
        name: In the table.
        bare: Log without it.
        loaded: Log with it.
        bare_rows: First and last row that are used, where its authors say; all if None.
        loaded_rows: Likewise.
    """

    name: str
    bare: str
    loaded: str
    bare_rows: tuple[int, int] | None = None
    loaded_rows: tuple[int, int] | None = None


GAINS = Pair(
    "19 February, 14 harmonics",
    "ur-20_02_19_14harm50sec.csv",
    "ur-20_02_19_14harm50secLoad.csv",
    (195, 4966),
    (308, 5071),
)
WEIGHED = (
    Pair("31 January", "ur-20_01_31-unload.csv", "ur-20_01_31-load.csv"),
    Pair(
        "19 February, 15 harmonics",
        "ur-20_02_19_15harm50sec.csv",
        "ur-20_02_19_15harm50secLoad.csv",
        loaded_rows=(11, 6106),  # wild values before, and it ends within a row
    ),
    Pair(
        "bare on 19 February, loaded on 31 January",
        "ur-20_02_19_15harm50sec.csv",
        "ur-20_01_31-load.csv",
    ),
)


@dataclass(frozen=True)
class Config:
    """What is weighed.

    Attributes:
        commit: At which the clone stands.
        pairs: By name.
        published: Gains beside ours [N m/A].
    """

    commit: str
    pairs: tuple[str, ...] = tuple(pair.name for pair in WEIGHED)
    published: tuple[float, ...] = PUBLISHED


@dataclass(frozen=True)
class Options(StudyOptions):
    """Is a load that was put on a scale weighed right by a real arm, from its motor currents?

    Attributes:
        repo: A local clone of the repository, or folders that hold it.
    """

    study: ClassVar[str] = "public_loads"
    repo: tuple[Path, ...] = ()


class Laboratory:
    """The clone's logs as data sets, each made once in a temporary folder.

    Args:
        clone: Of the repository.
        folder: For the data sets.
    """

    def __init__(self, clone: Path, folder: Path) -> None:
        self._clone, self._folder = clone, folder

    def imported(self, log: str, rows: tuple[int, int] | None, gains: Sequence[float] = ()) -> Path:
        """The data set of a log, all of it fitted; in amperes where no gains are given."""
        places = np.arange(2, 2 + 3 * JOINTS).reshape(3, JOINTS)
        names = {q: tuple(map(str, own)) for q, own in zip(("q", "dq", "tau"), places, strict=True)}
        choices = ImportChoices(
            robot=str(self._clone / ROBOT),
            columns={"t": ("1",), **names},
            torque="current",
            current_to_torque=tuple(gains),
            roles=("estimation",),
        )
        target = Path(tempfile.mkdtemp(dir=self._folder)) / Path(log).stem
        found = propose_import([self._cut(log, rows)], choices, target)
        write_import(found, target)
        return target

    def _cut(self, log: str, rows: tuple[int, int] | None) -> Path:
        """The rows that are used, in a file of their own; some logs end within a row."""
        lines = (self._clone / LOGS / log).read_text(encoding="ascii").splitlines()
        first, last = rows or (1, len(lines))
        whole = [line for line in lines[first - 1 : last] if line.count(",") == COLUMNS - 1]
        # The last of them may have been cut within its last number.
        copy = Path(tempfile.mkdtemp(dir=self._folder)) / log
        copy.write_text("\n".join(whole[:-1]) + "\n", encoding="ascii")
        return copy


def find_gains(laboratory: Laboratory) -> tuple[list[Row], Float[ndarray, " joints"]]:
    """Every joint's gain with its interval, and the best estimates, of those too that are not told."""
    bare = laboratory.imported(GAINS.bare, GAINS.bare_rows)
    loaded = laboratory.imported(GAINS.loaded, GAINS.loaded_rows)
    out = loaded.parent / "unused"
    gains = measure(Gains(bare=bare, loaded=(loaded,), mass=(MASS,), out=out)).gains
    estimates = np.exp(gains.consistent.log_k)
    rows: list[Row] = [
        {
            "joint": gain.joint,
            "gain [N m/A]": float(estimate),
            "lower": gain.interval[0] if gain.interval else None,
            "upper": gain.interval[1] if gain.interval else None,
            "published [N m/A]": published,
            "not told since": gain.reason,
        }
        for gain, estimate, published in zip(gains.gains, estimates, PUBLISHED, strict=True)
    ]
    return rows, estimates


def weigh_pair(laboratory: Laboratory, pair: Pair, whose: str, gains: Sequence[float]) -> Row:
    """The load of one pair of recordings; a failure is a row with its reason."""
    row: Row = {"recordings": pair.name, "gains": whose}
    try:
        bare = laboratory.imported(pair.bare, pair.bare_rows, gains)
        loaded = laboratory.imported(pair.loaded, pair.loaded_rows, gains)
        report = weigh(Payload(bare=bare, loaded=loaded, out=loaded.parent / "unused"))
    except OedError as error:
        return row | {"problem": str(error)}
    mass = next(one for one in report.payload.quantities if one.name == "mass")
    low, high = mass.interval or (np.nan, np.nan)
    return row | {
        "mass [kg]": mass.value,
        "lower": low,
        "upper": high,
        "off [%]": 100 * (mass.value / MASS - 1),
        "held": low <= MASS <= high,
    }


def summarise(gains: Sequence[Row], rows: Sequence[Row], commit: str) -> str:
    """The tables, and whether the claim stands.

    Args:
        gains: One row a joint.
        rows: One a weighing.
        commit: At which the clone stands.
    """
    ours = [row for row in rows if row["gains"] == OURS and "problem" not in row]
    worst = max((abs(float(row["off [%]"])) for row in ours), default=np.inf)  # pyright: ignore[reportArgumentType]
    held = sum(bool(row["held"]) for row in ours)
    stands = bool(ours) and worst <= MOST_OFF and held == len(ours)
    verdict = (
        f"UR10e, {REPOSITORY} at {commit}; the load is {MASS} kg. The claim, stated before the run: "
        f"with gains of one pair of recordings its mass comes out within {MOST_OFF:g} % in others, and "
        f"inside its interval. It {'stands' if stands else 'does not stand'}: the largest error is "
        f"{worst:.2g} %, and {held} of {len(ours)} intervals hold the mass."
    )
    title = f"## Gains, from {GAINS.name}"
    untold = "A gain without an interval is known no better than to ten per cent; its best estimate is used."
    lines = [
        "# A load that was put on a scale",
        "",
        verdict,
        "",
        title,
        "",
        markdown_table(gains),
        "",
    ]
    return "\n".join([*lines, untold, "", "## Mass", "", markdown_table(rows), ""])


def main(arguments: Sequence[str] | None = None) -> None:
    """Run from the command line."""
    options = parse(Options, prog="python -m studies.public_loads", arguments=arguments)
    clone = clone_of(str(LOGS / GAINS.bare), options.repo)
    if clone is None:
        fetch = f"git clone https://github.com/{REPOSITORY}"
        raise ValueError(f"--repo: no clone has {LOGS / GAINS.bare}; fetch it: {fetch}")
    pairs = WEIGHED[:1] if options.smoke else WEIGHED
    speak(quiet=True)
    with options.held(options.repo) as results, tempfile.TemporaryDirectory() as folder:
        laboratory = Laboratory(clone, Path(folder))
        gains, ours = find_gains(laboratory)
        both = ((OURS, tuple(ours.tolist())), ("published", PUBLISHED))
        rows = [weigh_pair(laboratory, pair, *of) for pair in pairs for of in both]
        commit = commit_of(clone)
        told = summarise(gains, rows, commit)
        with results.replaced() as new:
            write_csv(new / "runs.csv", [*rows])
            write_atomically(new / "summary.md", told)
            config = Config(commit, tuple(pair.name for pair in pairs))
            Provenance.collect(config, seed=None).write(new / "provenance.json")
    sys.stdout.write(told)


if __name__ == "__main__":
    leave(main, "studies.public_loads")
