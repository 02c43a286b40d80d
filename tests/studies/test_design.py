"""The design study, as a user runs it."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from oed.robot import imi_scara
from studies.design import main


def test_one_command_gives_a_motion_within_proven_limits(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert main(["--robot", "builtin:imi_scara", "--out", str(out), "--smoke"]) == 0
    record = json.loads((out / "design.json").read_text())
    promised = {
        "format", "robot", "joints", "class", "coefficients", "horizon", "instants", "J_k",
        "J_k_continuous", "J_d_log10", "J_d_log10_continuous", "d_efficiency", "certified_max",
        "limits", "optimiser", "seed", "cpu_s", "status", "versions",
    }  # fmt: skip
    assert promised <= set(record)
    assert np.isfinite(record["J_k"])
    motion = pd.read_csv(out / "motion.csv")
    limits = imi_scara().limits
    for kind, prefix in (("position", "q"), ("velocity", "dq"), ("acceleration", "ddq")):
        proven = np.array(record["certified_max"][kind])
        for joint, name in enumerate(record["joints"]):
            # The file's digits may round a value up to the bound itself.
            assert motion[f"{prefix}_{name}"].abs().max() <= proven[joint] * (1 + 1e-6)
            assert proven[joint] <= getattr(limits, kind)[joint, 1] * (1 + 1e-12)


@pytest.mark.parametrize("robot", ["absent.urdf", "builtin:puma"])
def test_a_robot_that_is_not_there_is_one_line(
    robot: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--robot", robot, "--out", str(tmp_path / "out")]) == 2
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    assert message.startswith("studies.design:")
    assert not (tmp_path / "out").exists()
