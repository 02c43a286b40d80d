"""The comparison with figaroh: what a peer answers is judged by our figures, and one that does not run is told."""

import json
import stat
import sys
from pathlib import Path

import numpy as np
import pytest

from oed.design.criteria import condition, information
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.report.table import read_csv
from oed.robot import arm_joints, load_robot
from studies import compare_figaroh
from studies.compare_figaroh import UR5

T = np.linspace(0.0, 8.0, 161)
RATES = 2 * np.pi / 8.0 * np.arange(1, 7)
MOTION = Motion(
    T,
    0.1 * np.sin(T[:, None] * RATES),
    0.1 * RATES * np.cos(T[:, None] * RATES),
    -0.1 * RATES**2 * np.sin(T[:, None] * RATES),
)
# Takes the place of an interpreter: called with the script, and told the request.
STAND_IN = f"""#!{sys.executable}
import json, sys
from pathlib import Path
asked = json.load(sys.stdin)
Path(asked["out"]).write_text((Path(__file__).parent / "answer.json").read_text())
"""


def stand_in(folder: Path) -> Path:
    answer = {
        "cpu_s": 2.0, "is_found": True, "cond_W": 1.0, "base_parameters": 48, "versions": {"figaroh": "0"},
        "T_F": T.tolist(), "P_F": MOTION.q.tolist(), "V_F": MOTION.dq.tolist(), "A_F": MOTION.ddq.tolist(),
    }  # fmt: skip
    (folder / "answer.json").write_text(json.dumps(answer))
    program = folder / "python"
    program.write_text(STAND_IN)
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return program


def test_a_motion_of_the_peer_is_judged_by_our_figures(tmp_path: Path) -> None:
    peer, out = stand_in(tmp_path), tmp_path / "out"
    given = ["--peer-python", str(peer), "--out", str(out), "--smoke"]
    assert compare_figaroh.main(given) == 0
    first, *ours = read_csv(out / "runs.csv")
    model = TorqueModel.standard(load_robot(UR5, joints=arm_joints(UR5)))
    columns = base_parameters(model).reduce(model.columns(MOTION))
    assert first["J_k"] == pytest.approx(condition(information(columns)), rel=1e-4)
    assert {row["tool"] for row in ours} == {"oed, slsqp", "oed, interior-point"}
    assert all(row["violation"] <= 1e-6 for row in ours)
    assert "figaroh: median J_k" in (out / "summary.md").read_text(encoding="utf-8")


def test_a_peer_that_does_not_run_has_found_nothing_and_lacked_nothing(tmp_path: Path) -> None:
    out = tmp_path / "out"
    given = ["--peer-python", str(tmp_path / "absent"), "--out", str(out), "--smoke"]
    assert compare_figaroh.main(given) == 1
    assert "absent" in read_csv(out / "runs.csv")[0]["status"]
    assert "figaroh did not run" in (out / "summary.md").read_text(encoding="utf-8")
