"""Spoilt inputs for every command, and what must hold of each run.

    python -m tests.studies.command_fuzz [--runs 2000] [--first 0] [--deadline 240]

Each run is a process of its own. Of each: a documented exit status, no traceback, an end before
the deadline, inputs that are as they were, one line where they are refused and nothing left of it,
and of a motion that is called usable, limits that a dense look at it does not refute.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import os
import resource
import signal
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oed.commands.main import COMMANDS, IN_STEPS
from oed.commands.main import run as oed
from oed.commands.options import parse
from oed.design.default_limits import with_default_limits
from oed.dynamics.cross_check import file_torque
from oed.dynamics.motion import Motion
from oed.errors import LONGEST_MESSAGE, OedError
from oed.experiment.read_dataset import read_robot
from oed.robot import Robot, load_arm
from tests.studies.spoiled_inputs import Case, make_case

# As the commands' own descriptions state them; 2 is also what a wrong option ends in.
STATUSES = {
    "cross-check": (0, 1, 2),
    "design": (0, 2, 3),
    "import": (0, 2),
    "check": (0, 2, 3),
    "identify": (0, 2),
    "feasible": (0, 2, 3),
    "payload": (0, 2, 3),
    "gains": (0, 2, 3),
    "diagnose": (0, 2),
    "calibrate": (0, 2, 3),
    "export": (0, 2),
    "demo": (0,),
}
REFUSED = 2
TOLERANCE = 1e-6  # a share of a limit: digits of the file, and sums in another order
SECONDS = 240.0  # of waiting, for a run; most take one, on a machine that has other work a few
MEMORY = 6_000_000_000  # [bytes]


def run_case(number: int, deadline: float = SECONDS) -> tuple[Case, int | None, list[str]]:
    """One run: the case, its exit status (None: killed at the deadline), and what was wrong."""
    with tempfile.TemporaryDirectory(prefix="oed-fuzz-") as scratch:
        inputs, out = Path(scratch) / "in", Path(scratch) / "out"
        inputs.mkdir()
        case = make_case(number, inputs)
        before = _digest(inputs)
        arguments = [a.replace("{in}", str(inputs)) for a in case.arguments]
        status = _in_process(case.command, [*arguments, "--out", str(out)], Path(scratch), deadline)
        told = (Path(scratch) / "stderr").read_text(errors="replace")
        faults = []
        if status is None:
            return case, None, [f"no end within {deadline:g} s"]
        if status not in STATUSES[case.command]:
            faults.append(f"exit status {status}")
        if "Traceback (most recent call last)" in told:
            faults.append(f"traceback: {told.strip().splitlines()[-1][:300]}")
        if _digest(inputs) != before:
            faults.append("an input was changed")
        if status == REFUSED:
            faults += _of_refusal(told, out, case)
        if case.command == "design" and status == 0:
            faults += _of_motion(inputs, arguments, out)
        return case, status, faults


def _in_process(command: str, arguments: list[str], scratch: Path, deadline: float) -> int | None:
    """The exit status of a command in a process of its own; None if it had to be killed."""
    child = os.fork()
    if child == 0:
        os.setsid()  # with the processes that it starts
        _become(command, arguments, scratch)
    end = time.monotonic() + deadline
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def _become(command: str, arguments: list[str], scratch: Path) -> None:
    """Run the command here, its output in files, and leave without a word of the caller's."""
    for name, number in (("stdout", 1), ("stderr", 2)):
        handle = os.open(scratch / name, os.O_WRONLY | os.O_CREAT)
        os.dup2(handle, number)
    sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    status = 99
    try:
        status = oed([command, *arguments])
    except SystemExit as error:
        status = error.code if isinstance(error.code, int) else 98
    except BaseException:  # noqa: BLE001  # whatever it is, it is what this looks for
        import traceback  # noqa: PLC0415  # of the child alone

        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)


def _digest(folder: Path) -> str:
    """Of all names, kinds and contents; what is no file is not opened."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        state = path.lstat()
        digest.update(f"{path.name} {state.st_mode} {state.st_size};".encode())
        if path.is_file() and not path.is_symlink() and state.st_size < 10**8:
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _of_refusal(told: str, out: Path, case: Case) -> list[str]:
    lines = [line for line in told.strip().splitlines() if "done in" not in line]
    faults = []
    if not lines or not lines[-1].strip():
        faults.append("refused without a word")
    elif not any(case.command in line for line in lines[-1:]):
        faults.append(f"refused in other words: {lines[-1][:300]}")
    if any(len(line) > LONGEST_MESSAGE + 500 for line in lines):
        faults.append(f"a line of {max(map(len, lines))} letters")
    if out.exists() and not (case.command in IN_STEPS and "steps that were done" in told):
        faults.append("refused, and something was left")
    return faults


def _of_motion(inputs: Path, arguments: list[str], out: Path) -> list[str]:
    """What a dense look refutes of a motion that is called usable."""
    record = json.loads((out / "design.json").read_text())
    try:
        robot, _ = with_default_limits(_robot(inputs, arguments, record["joints"]))
    except OedError as error:
        return [f"a motion of a robot that does not load: {error}"]
    motion = _dense(record)
    faults = [
        f"{kind} reaches {share:.9g} of its limit"
        for kind, values in (
            ("position", motion.q),
            ("velocity", motion.dq),
            ("acceleration", motion.ddq),
        )
        if (share := _share(values, getattr(robot.limits, kind))) > 1 + TOLERANCE
    ]
    if record["certified_max"].get("torque") and robot.description is not None:
        few = Motion(*(x[::50] for x in (motion.t, motion.q, motion.dq, motion.ddq)))
        share = _share(file_torque(robot, few), robot.limits.torque)
        faults += [f"torque reaches {share:.9g} of its limit"] if share > 1 + TOLERANCE else []
    if not np.isfinite([record["J_d_log10"] or np.nan]).all():
        faults.append("a usable motion without information")
    return faults


def _robot(inputs: Path, arguments: list[str], joints: list[str]) -> Robot:
    if "--data" in arguments:
        return read_robot(inputs, joints=joints)
    return load_arm(arguments[arguments.index("--robot") + 1], joints=joints)


def _dense(record: dict) -> Motion:  # the record of a design
    """The Fourier series of a design's coefficients, written out."""
    t = np.linspace(0, record["horizon"], 20_001)
    given = {key: np.array(value) for key, value in record["coefficients"].items()}
    q = np.tile(given["offset"], (len(t), 1))
    dq, ddq = np.zeros_like(q), np.zeros_like(q)
    for k in range(given["sine"].shape[1]):
        w = 2 * np.pi * (k + 1) / record["horizon"]
        s, c = np.sin(w * t)[:, None], np.cos(w * t)[:, None]
        a, b = given["sine"][:, k], given["cosine"][:, k]
        q, dq, ddq = q + a * s + b * c, dq + w * (a * c - b * s), ddq - w**2 * (a * s + b * c)
    return Motion(t, q, dq, ddq)


def _share(values: np.ndarray, limits: np.ndarray) -> float:
    """How much of the half range is used, from its middle; 0 where there is no limit."""
    lower, upper = limits.T
    is_limited = np.isfinite(lower) & np.isfinite(upper)
    half, middle = (upper - lower)[is_limited] / 2, (upper + lower)[is_limited] / 2
    return float((np.abs(values[:, is_limited] - middle) / half).max(initial=0.0))


@dataclass(frozen=True)
class Options:
    """Spoilt inputs for every command.

    Attributes:
        runs: Number of cases.
        first: Number of the first.
        deadline: Of a run [s].
    """

    runs: int = 2000
    first: int = 0
    deadline: float = SECONDS


def main(argv: list[str] | None = None) -> int:
    """Run many cases; 1 if anything was wrong with one of them."""
    given = parse(Options, prog="command_fuzz", arguments=argv)
    for command in STATUSES:  # once, so that a run need not
        importlib.import_module(f"oed.commands.{COMMANDS[command][1]}")
    count: Counter[str] = Counter()
    for number in range(given.first, given.first + given.runs):
        case, status, faults = run_case(number, given.deadline)
        count[f"{case.command} {status}"] += 1
        for fault in faults:
            count["faults"] += 1
            print(f"{number}: {case.command} ({case.spoilt}): {fault}", flush=True)
        if (number - given.first) % 100 == 99:
            print(f"up to {number}: {dict(sorted(count.items()))}", flush=True)
    print(f"{given.runs} runs from {given.first}: {dict(sorted(count.items()))}", flush=True)
    return 1 if count["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
