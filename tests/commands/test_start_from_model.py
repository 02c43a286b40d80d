"""An estimate that starts from a model.json has its effects; another arm's is refused."""

import numpy as np
import pytest

from oed.experiment.write_dataset import write_dataset
from oed.export.model_file import load_model, write_model
from tests.diagnosis.arm import NOISE, data_set
from tests.dynamics.effects.arms import panda, smooth_motion
from tests.export.every_effect import model_with
from tests.running import oed

SPRING, OFFSET = 9.0, 4.0


def pull(q, dq, ddq):
    """A spring at the second joint, and a bend that no catalogue knows."""
    result = np.zeros_like(q)
    result[:, 1] = SPRING * q[:, 1] + OFFSET
    return result


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """A diagnosis of a sprung arm, and its data."""
    folder = tmp_path_factory.mktemp("sprung")
    write_dataset(data_set(52, extra=pull, repetitions=2), folder / "data")
    told = ("--method", "evidence", "--model", "standard", "--quiet")
    few = ("--candidates", "joint_spring", "torque_offset", "stribeck")
    assert oed("diagnose", folder / "data", "--out", folder / "found", *told, *few) == 0
    return folder


def test_least_squares_finds_the_spring_again(found, tmp_path):
    start = found / "found" / "model.json"
    assert oed("identify", found / "data", "--out", tmp_path, "--model", start, "--quiet") == 0
    model = load_model(tmp_path / "model.json")
    values = dict(
        zip((p.name for p in model.torque_model.parameters), model.parameters, strict=True)
    )
    assert values["spring_2"] == pytest.approx(SPRING, rel=0.02)
    again = load_model(start)
    motion = smooth_motion(model.robot, 2.0)
    differ = again.torque(motion.q, motion.dq, motion.ddq) - model.torque(
        motion.q, motion.dq, motion.ddq
    )
    assert np.sqrt(np.mean(differ**2, axis=0)) == pytest.approx(0, abs=NOISE.max() / 5)
    assert [s.name for s in model.shapes[-1]] == [s.name for s in again.shapes[-1]]


def test_a_model_of_another_arm_is_refused(found, tmp_path, capsys):
    other, _ = model_with(robot=panda(), duration=0.1)
    path = write_model(other, tmp_path / "other.json")
    assert oed("identify", found / "data", "--out", tmp_path / "o", "--model", path) == 2
    assert "its joints are panda_joint1" in capsys.readouterr().err
    assert oed("identify", found / "data", "--out", tmp_path / "o", "--model", "rotr") == 2
    assert "rotr: no such file" in capsys.readouterr().err
