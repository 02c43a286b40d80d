"""What `import oed` offers: exactly what the documentation says, each with a page of its own."""

from __future__ import annotations

import re
import subprocess
import sys

import numpy as np
import pytest

import oed
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.robot.builtin import IMI_COULOMB, IMI_VISCOUS
from tests.paths import REPO


def test_the_documentation_lists_exactly_what_is_offered() -> None:
    page = (REPO / "docs/reference/api.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^::: oed\.(?:\w+\.)*(\w+)$", page, re.MULTILINE)) == sorted(
        oed.__all__
    )


@pytest.mark.parametrize("name", oed.__all__)
def test_everything_offered_says_what_it_is(name: str) -> None:
    assert len((getattr(oed, name).__doc__ or "").split()) > 2


def test_nothing_is_loaded_before_it_is_used() -> None:
    code = "import oed, sys; print({'numpy', 'casadi', 'pydrake'} & set(sys.modules))"
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
