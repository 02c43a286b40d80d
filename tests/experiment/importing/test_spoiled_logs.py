"""Whatever is wrong with a log, there is one clear line, and nothing is written."""

from pathlib import Path

import numpy as np
import pytest

from oed.robot import load_robot
from tests.experiment.importing.eleven_logs import (
    LOGS,
    TORQUE_CONSTANT,
    Truth,
    simulate,
    write_urdf,
)
from tests.running import oed

ROUNDS = 20  # spoiled files of each kind
LONGEST = 2500  # letters of a line that names a file and says what to do


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    return write_urdf(tmp_path_factory.mktemp("arm") / "arm.urdf")


@pytest.fixture(scope="module")
def truth(arm) -> Truth:
    return simulate(load_robot(arm), rows=240)


def spoiled(content: bytes, rng: np.random.Generator) -> bytes:
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


def tree(folder: Path) -> list[tuple[str, bytes]]:
    return sorted(
        (str(p.relative_to(folder)), p.read_bytes()) for p in folder.rglob("*") if p.is_file()
    )


@pytest.mark.parametrize("kind", LOGS)
def test_a_spoiled_log_is_imported_or_refused_in_one_line(kind, arm, truth, tmp_path, capsys):
    log = LOGS[kind](truth, tmp_path)
    file = next(log.glob("*.db3")) if log.is_dir() else log
    more = ["--current-to-torque", *map(str, TORQUE_CONSTANT)] if kind.startswith("RTDE") else []
    whole = file.read_bytes()
    rng = np.random.default_rng(sorted(LOGS).index(kind))
    outcomes = []
    for i in range(ROUNDS):
        file.write_bytes(spoiled(whole, rng))
        before = tree(tmp_path)
        out = tmp_path / f"set{i}"
        code = oed("import", str(log), "--robot", str(arm), "--out", str(out), *more)
        outcomes.append(code)
        told = capsys.readouterr().err
        if code == 0:
            assert (out / "dataset.toml").is_file()
            continue
        assert code == 2
        assert told.count("\n") == 1
        assert "oed import: " in told
        assert len(told) < LONGEST
        assert tree(tmp_path) == before
        assert not out.exists()
    assert outcomes.count(2) > ROUNDS / 4
