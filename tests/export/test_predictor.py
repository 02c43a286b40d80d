"""One instant after another, symbols and C give the torque that the model gives a whole recording."""

import ctypes
import dataclasses
import itertools
import subprocess

import numpy as np
import pytest

from oed.export.c_code import write_c
from oed.export.predictor import Predictor, Running
from tests.dynamics.effects.arms import panda, smooth_motion
from tests.export.every_effect import EFFECTS, STEP, model_with

GEARS = {"backlash", "joint_elasticity"}
PAIRS = list(itertools.combinations(EFFECTS, 2))
CHOSEN = np.random.default_rng(11).choice(len(PAIRS), 12, replace=False)


def whole(predictor, motion):
    return predictor.model.torque(predictor.parameters, motion)


def one_by_one(predictor, motion):
    running = Running(predictor)
    return np.array([running(*x) for x in zip(motion.q, motion.dq, motion.ddq, strict=True)])


def agrees(found, expected, share=1e-12):
    return np.abs(found - expected).max() <= share * np.abs(expected).max()


@pytest.mark.parametrize(
    "names", [*((name,) for name in EFFECTS), *(PAIRS[k] for k in CHOSEN)], ids="+".join
)
def test_is_the_model_along_a_recording(names):
    model, motion = model_with(*names, duration=0.9)
    predictor = Predictor.of(model, STEP)
    assert agrees(one_by_one(predictor, motion), whole(predictor, motion))
    assert {left.name for left in predictor.left_out} == GEARS & set(names)
    assert all(left.reason for left in predictor.left_out)


def test_free_forms_beside_every_effect():
    model, motion = model_with(*EFFECTS, forms=True, duration=0.9)
    predictor = Predictor.of(model, STEP)
    assert agrees(one_by_one(predictor, motion), whole(predictor, motion))


def test_a_delay_of_part_of_a_step_lies_between_two():
    model, motion = model_with("time_delay", duration=2.0)
    half = Predictor.of(model, 2 * STEP)
    every_other = motion[::2]
    found, expected = one_by_one(half, every_other), whole(half, every_other)
    assert agrees(found, expected, 2e-4)
    assert not agrees(found[1:], whole(half, dataclasses.replace(every_other))[:-1], 2e-3)


def test_parts_add_up_to_what_the_arm_needs():
    names = ("joint_spring", "stribeck", "rotor_inertia", "motor_coupling", "payload_change")
    model, motion = model_with(*names, duration=0.3)
    functions = Predictor.of(model, STEP).functions
    state = (motion.q[7], motion.dq[7], motion.ddq[7])
    memory = functions["arm_begin"](*state)
    arm, _ = functions["arm"](*state, memory)
    parts = [functions[p](*state, memory) for p in ("gravity", "position", "friction", "inertia")]
    assert np.sum([np.array(p) for p in parts], axis=0) == pytest.approx(np.array(arm), rel=1e-12)
    at_rest = [functions[p](state[0], 0, 0, memory) for p in ("gravity", "friction", "inertia")]
    weight, friction, inertia = (np.array(x).ravel() for x in at_rest)
    assert weight == pytest.approx(np.array(parts[0]).ravel())
    assert np.abs(friction).max() == np.abs(inertia).max() == 0


class Compiled:
    """C code of a predictor, compiled by the machine's compiler as C99 and called as any program would."""

    def __init__(self, predictor, folder):
        source, _ = write_c(predictor, folder)
        library = folder / "model.so"
        flags = ["-std=c99", "-Wall", "-Werror", "-O1", "-fPIC", "-shared"]
        subprocess.run(["cc", *flags, source, "-o", library, "-lm"], check=True, cwd=folder)
        self._library, self._n = ctypes.CDLL(str(library)), predictor.n
        self._kept = max(len(predictor.recorded.keeps), 1)

    def torque(self, motion):
        q, dq, ddq = (np.ascontiguousarray(getattr(motion, x)) for x in ("q", "dq", "ddq"))
        memory, following, tau = np.zeros(self._kept), np.zeros(self._kept), np.zeros(self._n)
        self._call("torque_begin", q[0], dq[0], ddq[0], memory)
        found = []
        for k in range(len(motion)):
            self._call("torque", q[k], dq[k], ddq[k], memory, tau, following)
            memory[:] = following
            found.append(tau.copy())
        return np.array(found)

    def _call(self, name, *arrays):
        pointers = [x.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for x in arrays]
        getattr(self._library, f"oed_model_{name}")(*pointers)


def test_c_of_every_effect_and_free_form(tmp_path):
    model, motion = model_with(*EFFECTS, forms=True, duration=0.6)
    predictor = Predictor.of(model, STEP)
    assert agrees(Compiled(predictor, tmp_path).torque(motion), whole(predictor, motion), 1e-11)
    header = (tmp_path / "oed_model.h").read_text(encoding="utf-8")
    assert "Left out: backlash: how far the gear gives way" in header


def test_c_of_seven_joints(tmp_path):
    robot = panda()
    model, _ = model_with("load_dependent_friction", "stribeck", robot=robot, duration=0.3)
    predictor, motion = Predictor.of(model, STEP), smooth_motion(robot, 0.3, STEP)
    assert agrees(Compiled(predictor, tmp_path).torque(motion), whole(predictor, motion), 1e-11)


def test_a_step_must_be_positive():
    with pytest.raises(ValueError, match="step"):
        Predictor.of(model_with(duration=0.1)[0], 0.0)
