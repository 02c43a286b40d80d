"""What `import oed` offers: exactly what the documentation says, each with a page of its own."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import pytest

import oed
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.report.json_file import read_json
from oed.robot import load_robot
from oed.robot.builtin import IMI_COULOMB, IMI_VISCOUS
from tests.docs.code_blocks import blocks
from tests.experiment.importing.laboratory_logs import bag_mcap, simulate, write_urdf
from tests.paths import REPO


def test_the_documentation_lists_exactly_what_is_offered() -> None:
    page = (REPO / "docs/reference/api.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^::: oed\.(?:\w+\.)*(\w+)$", page, re.MULTILINE)) == sorted(
        oed.__all__
    )


@pytest.mark.parametrize("name", oed.__all__)
def test_everything_offered_says_what_it_is(name: str) -> None:
    assert len((getattr(oed, name).__doc__ or "").split()) > 2


def test_every_step_of_a_notebook_has_its_name() -> None:
    """From a robot or a log to a model that is handed on."""
    steps = {
        "load_arm", "import_log", "read_dataset", "write_dataset", "check", "design_motion",
        "identify", "identify_feasible", "diagnose_data", "export_model", "export_motion",
        "load_model", "plot_residuals", "plot_torques",
    }  # fmt: skip
    assert steps <= set(oed.__all__)
    for name in steps:
        hints = get_type_hints(getattr(oed, name))
        assert "return" in hints, name
        assert len(hints) - 1 == len(inspect.signature(getattr(oed, name)).parameters), name


def test_from_a_log_to_a_model_that_is_handed_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The example of the documentation, and what it leaves."""
    (example,) = blocks(REPO / "docs/reference/api.md", "python")
    monkeypatch.chdir(tmp_path)
    robot = load_robot(write_urdf(tmp_path / "arm.urdf"))
    truth = simulate(robot, rows=1500)
    bag_mcap(truth, tmp_path).rename(tmp_path / "log.mcap")
    names: dict[str, Any] = {}
    exec(compile(example, "api.md", "exec"), names)  # noqa: S102  # our own page
    assert names["dataset"].name == "mydata"
    found = oed.load_model("export/model.json")
    assert found.origin.command == "oed identify"
    assert read_json(Path("export/export.json"))["exports"]["c"]["files"]
    # Nothing is left of a log that is only looked at.
    before = sorted(tmp_path.iterdir())
    dataset = oed.import_log(
        ["log.mcap"], tmp_path / "arm.urdf", sign=[1.0, 1.0, 1.0], roles=["estimation"]
    )
    assert sorted(tmp_path.iterdir()) == before
    (whole,) = dataset.recordings
    np.testing.assert_allclose(whole.tau, truth.tau, atol=1e-9)
    with pytest.raises(oed.OedError, match="feasible"):
        oed.export_model(found, "urdf", to=["urdf"])
    with pytest.raises(ValueError, match="form"):
        oed.export_model(found, "x", to=["no_such_form"])
    assert sorted(tmp_path.iterdir()) == before


def test_a_motion_is_written_for_controllers(tmp_path: Path) -> None:
    found = oed.design_motion("builtin:imi_scara", evaluations=20, seed=0)
    files = oed.export_motion(found, tmp_path / "motion", rate=50.0)
    assert files[0].name == "motion.csv"
    rows = np.loadtxt(files[0], delimiter=",", skiprows=1)
    assert len(rows) == round(50.0 * found.design.horizon) + 1
    np.testing.assert_allclose(rows[:, 1:3], found.design.motion(rows[:, 0]).q, atol=1e-6)
    assert oed.export_motion(found, tmp_path / "motion", rate=50.0) == files
    mine = tmp_path / "mine" / "motion.csv"
    mine.parent.mkdir()
    mine.write_text("mine")
    with pytest.raises(ValueError, match=r"motion\.csv"):
        oed.export_motion(found, mine.parent)
    assert mine.read_text() == "mine"


def test_nothing_is_loaded_before_it_is_used() -> None:
    code = "import oed, sys; print({'numpy', 'casadi', 'pydrake'} & set(sys.modules))"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == "set()"


def test_identify_loads_only_what_it_uses() -> None:
    heavy = "{'casadi', 'pandas', 'pyarrow', 'matplotlib', 'cvxpy', 'h5py', 'rosbags', 'numba', 'xacro'}"
    code = f"import oed.commands.identify, sys; print({heavy} & set(sys.modules))"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == "set()"


def test_ten_lines_from_arrays_to_parameters() -> None:
    rng = np.random.default_rng(5)
    robot = oed.load_arm("builtin:imi_scara")
    friction = [x for pair in zip(IMI_COULOMB, IMI_VISCOUS, strict=True) for x in pair]
    truth = np.concatenate([robot.parameters, friction])
    recorded = [_recorded(rng, truth) for _ in range(2)]
    dataset = oed.DataSet.from_arrays(
        robot,
        t=[motion.t for motion, _ in recorded],
        q=[motion.q for motion, _ in recorded],
        tau=[tau for _, tau in recorded],
        roles=["estimation", "validation"],
    )
    calibration = oed.identify(dataset, model="standard")
    found = dict(zip(calibration.estimate.names, calibration.estimate.parameters, strict=True))
    # Gamma_2z of the paper's arm, and Coulomb friction of joint 1.
    assert found["Izz_2"] == pytest.approx(robot.parameters[19], rel=0.02)
    assert found["Fc_1"] == pytest.approx(IMI_COULOMB[0], rel=0.05)
    assert (calibration.validation["validation"].relative_rms < 0.05).all()
    assert oed.plot_residuals is not None


def _recorded(rng: np.random.Generator, truth: np.ndarray) -> tuple[Motion, np.ndarray]:
    t = np.arange(0.0, 20.0, 0.004)
    w, a = 2 * np.pi * rng.uniform(0.1, 0.6, (2, 4)), rng.uniform(0.1, 0.3, (2, 4))
    phase = t[:, None, None] * w + rng.uniform(0, 2 * np.pi, (2, 4))
    motion = Motion(
        t,
        (a * np.sin(phase)).sum(2),
        (a * w * np.cos(phase)).sum(2),
        -(a * w**2 * np.sin(phase)).sum(2),
    )
    model = build_model("standard", oed.load_arm("builtin:imi_scara"), sign_width=0.02)
    return motion, model.torque(truth, motion) + rng.normal(size=motion.q.shape) * 0.02
