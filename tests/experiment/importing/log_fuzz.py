"""Spoiled logs of every kind: each is imported, or refused in one line with nothing written.

    python -m tests.experiment.importing.log_fuzz [--rounds 80] [--seed 1]

prints how many of each kind ended in which way, and what was wrong.
"""

from __future__ import annotations

import contextlib
import io
import shutil
import sys
import tempfile
import warnings
from collections import Counter
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from oed.commands.configurations import ImportLog
from oed.commands.import_log import run
from oed.commands.options import parse
from oed.process_end import exit_status
from oed.robot import load_robot
from tests.experiment.importing.laboratory_logs import (
    LOGS,
    TORQUE_CONSTANT,
    Truth,
    simulate,
    write_urdf,
)
from tests.experiment.importing.log_spoiling import spoiled_bytes, spoiled_text, spoiled_truth

ROWS = 160  # of a log before it is spoiled
LONGEST = 2500  # letters of a line that names a file and says what to do
IMPORTED, REFUSED = 0, 2


@dataclass(frozen=True)
class Outcome:
    """How an import ended: its exit status, None if it raised, and what was wrong with that."""

    status: int | None
    fault: str = ""


@dataclass(frozen=True)
class Config:
    """How many logs to spoil.

    Attributes:
        rounds: Spoiled logs of each kind.
        seed: Of what is spoiled, and how.
    """

    rounds: int = 80
    seed: int = 1


def fuzz(kind: str, truth: Truth, robot: Path, folder: Path, config: Config) -> list[Outcome]:
    """Spoil a log of one kind again and again, and import it each time."""
    rng = np.random.default_rng((config.seed, sorted(LOGS).index(kind)))
    sound = folder / "sound"
    sound.mkdir()
    log = LOGS[kind](truth, sound)
    is_text, is_bag = log.suffix in (".csv", ".txt"), log.is_dir() or log.suffix == ".mcap"
    # Writing a bag takes ten times as long as reading it.
    ways = ["bytes", "text" if is_text else "bytes", "bytes" if is_bag else "truth", "truth"]
    outcomes = []
    for number in range(config.rounds):
        inputs = folder / str(number)
        way = rng.choice(ways)
        if way == "truth":
            inputs.mkdir()
            given = LOGS[kind](spoiled_truth(truth, rng), inputs)
        else:
            shutil.copytree(sound, inputs)
            given = inputs / log.relative_to(sound)
            file = next(given.glob("*.db3")) if given.is_dir() else given
            spoil = spoiled_text if way == "text" else spoiled_bytes
            file.write_bytes(spoil(file.read_bytes(), rng))
        outcome = _outcome(_asked(kind, given, robot, inputs / "set"), inputs)
        if outcome.fault:
            outcome = Outcome(outcome.status, f"{kind} {number} ({way}): {outcome.fault}")
        outcomes.append(outcome)
        shutil.rmtree(inputs)
    return outcomes


def _asked(kind: str, log: Path, robot: Path, out: Path) -> ImportLog:
    currents = TORQUE_CONSTANT if kind.startswith("RTDE") else ()
    return ImportLog(logs=(log,), robot=str(robot), out=out, current_to_torque=currents)


def _outcome(config: ImportLog, inputs: Path) -> Outcome:
    """How a command ends that was told so; reading its words takes longer than its work."""
    before = _tree(inputs)
    told = io.StringIO()
    try:
        with contextlib.redirect_stderr(told), contextlib.redirect_stdout(io.StringIO()):
            status = exit_status(partial(run, config), "oed import")
    except Exception as error:  # noqa: BLE001  # whatever it is, it is what this looks for
        return Outcome(None, repr(error))
    text = told.getvalue()
    if status == IMPORTED:
        is_there = (config.out / "dataset.toml").is_file()
        return Outcome(status, "" if is_there else "nothing was written")
    if status != REFUSED or text.count("\n") != 1 or "oed import: " not in text:
        return Outcome(status, f"told in other words: {text[:300]}")
    if len(text) > LONGEST:
        return Outcome(status, f"a line of {len(text)} letters")
    return Outcome(status, "" if _tree(inputs) == before else "something was left")


def _tree(folder: Path) -> list[tuple[str, bytes]]:
    return sorted(
        (str(p.relative_to(folder)), p.read_bytes()) for p in folder.rglob("*") if p.is_file()
    )


def main() -> None:
    """Spoil logs of every kind."""
    config = parse(Config, prog="log_fuzz")
    warnings.simplefilter("error")
    total: Counter[int | None] = Counter()
    faults = 0
    with tempfile.TemporaryDirectory() as scratch:
        robot = write_urdf(Path(scratch) / "arm.urdf")
        truth = simulate(load_robot(robot), rows=ROWS)
        for i, kind in enumerate(LOGS):
            folder = Path(scratch) / str(i)
            folder.mkdir()
            outcomes = fuzz(kind, truth, robot, folder, config)
            count = Counter(outcome.status for outcome in outcomes)
            print(f"{kind}: {count[IMPORTED]} imported, {count[REFUSED]} refused", flush=True)
            for number, outcome in enumerate(outcomes):
                if outcome.fault:
                    print(f"  {number}: {outcome.fault}", flush=True)
                    faults += 1
            total += count
    print(
        f"{total.total()} logs: {total[IMPORTED]} imported, {total[REFUSED]} refused, {faults} faults"
    )
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
