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
from pathlib import Path

import numpy as np

from oed.commands.options import parse
from oed.robot import load_robot
from tests.experiment.importing.laboratory_logs import (
    LOGS,
    TORQUE_CONSTANT,
    Truth,
    simulate,
    write_urdf,
)
from tests.running import oed

ROWS = 240  # of a log before it is spoiled
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
    log = LOGS[kind](truth, folder)
    file = next(log.glob("*.db3")) if log.is_dir() else log
    more = ["--current-to-torque", *map(str, TORQUE_CONSTANT)] if kind.startswith("RTDE") else []
    whole = file.read_bytes()
    rng = np.random.default_rng((config.seed, sorted(LOGS).index(kind)))
    outcomes = []
    for _ in range(config.rounds):
        file.write_bytes(_spoiled(whole, rng))
        out = folder / "set"
        arguments = [str(log), "--robot", str(robot), "--out", str(out), *more]
        outcomes.append(_outcome(arguments, folder, out))
        shutil.rmtree(out, ignore_errors=True)
    return outcomes


def _spoiled(content: bytes, rng: np.random.Generator) -> bytes:
    """Cut off, altered, doubled or emptied somewhere."""
    at = int(rng.integers(0, len(content)))
    kind = rng.choice(
        ["cut", "bytes", "zeros", "double", "drop", "empty"], p=[0.3, 0.25, 0.1, 0.1, 0.2, 0.05]
    )
    if kind == "cut":
        return content[:at]
    if kind == "empty":
        return b""
    span = int(rng.integers(1, 400))
    new = {"bytes": rng.bytes(span), "zeros": bytes(span), "double": content[at : at + span] * 2}
    return content[:at] + new.get(str(kind), b"") + content[at + span :]


def _outcome(arguments: list[str], folder: Path, out: Path) -> Outcome:
    before = _tree(folder)
    told = io.StringIO()
    try:
        with contextlib.redirect_stderr(told), contextlib.redirect_stdout(io.StringIO()):
            status = oed("import", *arguments)
    except Exception as error:  # noqa: BLE001  # whatever it is, it is what this looks for
        return Outcome(None, repr(error))
    text = told.getvalue()
    if status == IMPORTED:
        return Outcome(status, "" if (out / "dataset.toml").is_file() else "nothing was written")
    if status != REFUSED or text.count("\n") != 1 or "oed import: " not in text:
        return Outcome(status, f"told in other words: {text[:300]}")
    if len(text) > LONGEST:
        return Outcome(status, f"a line of {len(text)} letters")
    return Outcome(status, "" if _tree(folder) == before else "something was left")


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
