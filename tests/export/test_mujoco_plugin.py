"""The plug-in for MuJoCo, compiled: its force is that of the Python callback, step by step."""

import itertools
import shutil
import subprocess
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest

from oed.export.bodies import calibrated_robot
from oed.export.mjcf import write_mjcf
from oed.export.mujoco_force import PassiveForce
from oed.export.mujoco_plugin import write_plugin
from tests.dynamics.effects.arms import panda, vertical_arm
from tests.export.every_effect import EFFECTS, model_with

HOME = Path(mujoco.__path__[0])
LIBRARY = next(HOME.glob("libmujoco.so*"), None)
STEP, STEPS = 1e-3, 60
ARMS = {"scara": vertical_arm, "panda": panda}
SOME = ("stribeck", "load_dependent_friction", "presliding_hysteresis", "joint_spring")
GROUPS = 4
NUMBERS = itertools.count()  # a plug-in's name is taken for good

pytestmark = pytest.mark.skipif(
    LIBRARY is None or shutil.which("cc") is None, reason="needs a C compiler and libmujoco.so"
)


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where MuJoCo leaves the log of its warnings


@cache
def model_of(arm, names):
    return model_with(*names, robot=ARMS[arm](), duration=0.4)[0]


def compiled(folder, model, **options):
    """The simulation of a model with its plug-in, and of the robot alone."""
    robot = write_mjcf(calibrated_robot(model), folder / "robot_mujoco.xml", dry_friction=False)
    source, scene = write_plugin(model, folder, step=STEP, name=f"test {next(NUMBERS)}", **options)
    library = folder / "liboed_passive.so"
    command = ["cc", "-shared", "-fPIC", "-Wall", "-Werror", "-Wno-unused-function"]
    command += ["-Wno-maybe-uninitialized", "-Wno-unused-variable", f"-I{HOME / 'include'}"]
    subprocess.run([*command, source, "-o", library, LIBRARY, "-lm"], check=True, timeout=120)
    mujoco.mj_loadPluginLibrary(str(library))
    alone = mujoco.MjModel.from_xml_path(str(robot))
    alone.opt.timestep = STEP
    return mujoco.MjModel.from_xml_path(str(scene)), alone


def fall(mjmodel, start, speed, callback=None):
    data = mujoco.MjData(mjmodel)
    data.qpos[:], data.qvel[:] = start, speed
    mujoco.set_mjcb_passive(callback)
    try:
        states = []
        for _ in range(STEPS):
            mujoco.mj_step(mjmodel, data)
            states.append([*data.qpos, *data.qvel])
    finally:
        mujoco.set_mjcb_passive(None)
    return np.array(states)


@pytest.mark.parametrize(
    ("arm", "names"),
    [("panda", SOME), *(("scara", tuple(EFFECTS)[k::GROUPS]) for k in range(GROUPS))],
)
def test_moves_as_with_the_callback(tmp_path, arm, names):
    model = model_of(arm, names)
    with_plugin, alone = compiled(tmp_path, model)
    rng = np.random.default_rng(2)
    start, speed = rng.uniform(-0.5, 0.5, (2, alone.nq))
    expected = fall(alone, start, speed, PassiveForce(model, alone))
    assert fall(with_plugin, start, speed) == pytest.approx(expected, rel=1e-9, abs=1e-12)
    # The force is there: without it the arm moves otherwise.
    assert np.abs(fall(alone, start, speed) - expected).max() > 1e-6


def test_begins_anew_when_it_is_reset(tmp_path):
    model = model_of("scara", ("presliding_hysteresis",))
    mjmodel, _ = compiled(tmp_path, model)
    data = mujoco.MjData(mjmodel)
    ends = []
    for _ in range(2):
        mujoco.mj_resetData(mjmodel, data)
        data.qpos[:], data.qvel[:] = (0.3, -0.2), (0.4, 0.1)
        for _ in range(STEPS):
            mujoco.mj_step(mjmodel, data)
        ends.append(data.qpos.copy())
    assert np.array_equal(*ends)


@pytest.mark.parametrize(
    ("field", "value"), [("integrator", int(mujoco.mjtIntegrator.mjINT_RK4)), ("timestep", 2e-3)]
)
def test_a_memory_goes_on_once_a_step_of_its_own_length(tmp_path, field, value):
    mjmodel, _ = compiled(tmp_path, model_of("scara", ("presliding_hysteresis",)))
    setattr(mjmodel.opt, field, value)
    with pytest.raises(mujoco.FatalError, match="init failed"):
        mujoco.MjData(mjmodel)


def test_joints_that_a_simulation_lacks_are_refused(tmp_path):
    model = model_of("scara", ("stribeck",))
    compiled(tmp_path, model)
    scene = tmp_path / "robot_plugin.xml"
    robot = tmp_path / "robot_mujoco.xml"
    text = robot.read_text().replace(f'"{model.robot.joint_names[0]}"', '"another"')
    robot.write_text(text)
    with pytest.raises(ValueError, match="has no joint joint_1"):
        mujoco.MjModel.from_xml_path(str(scene))
