"""MuJoCo and Drake compute the model's torque, with every effect that can act in a simulation."""

import dataclasses
import itertools
from functools import cache

import mujoco
import numpy as np
import pytest

from oed.dynamics.motion import random_motion
from oed.dynamics.online import without_offline
from oed.export.bodies import calibrated_robot
from oed.export.effect_torque import not_simulated, whole_arm
from oed.export.mjcf import write_mjcf
from oed.export.mujoco_force import PassiveForce
from oed.export.round_trip import torque_by_drake
from oed.export.simulation_plant import EffectDrive, build_simulation, build_simulation_plant
from oed.robot import JointLimits, load_robot
from tests.dynamics.effects.arms import panda, vertical_arm
from tests.estimation.feasible.cases import UR5, random_tree
from tests.export.every_effect import EFFECTS, STEP, model_with
from tests.paths import example_robot

MEASURED = {
    "torque_gain",
    "time_delay",
    "filter_lag",
    "joint_elasticity",
    "backlash",
    "encoder_eccentricity",
}
PAIRS = list(itertools.combinations(EFFECTS, 2))
CHOSEN = [PAIRS[k] for k in np.random.default_rng(7).choice(len(PAIRS), 15, replace=False)]
ARMS = {
    "scara": vertical_arm,
    "ur5": lambda: load_robot(example_robot(UR5)),
    "panda": panda,
    "tree": lambda: random_tree(6, np.random.default_rng(3)),
}
SOME = ("stribeck", "load_dependent_friction", "presliding_hysteresis", "joint_spring")
CASES = [
    *(("scara", (name,)) for name in EFFECTS),
    *(("scara", pair) for pair in CHOSEN),
    *((arm, SOME) for arm in ("ur5", "panda", "tree")),
]


@cache
def case(arm, names):
    """A model, states within the limits one step after another, and the arm's own torque there."""
    robot = ARMS[arm]()
    model, _ = model_with(*names, robot=robot, duration=0.4)
    states = dataclasses.replace(
        random_motion(robot, 40, np.random.default_rng(1)), t=np.arange(40) * STEP
    )
    return model, states


def arms_torque(model, motion):
    """Of the model without its measurement."""
    whole, parameters = without_offline(model.torque_model, model.parameters)
    return dataclasses.replace(whole, measurement=()).torque(parameters, motion)


def agrees(found, expected):
    return np.abs(found - expected).max() <= 1e-10 * np.abs(expected).max()


def mjmodel_of(model, folder):
    path = write_mjcf(calibrated_robot(model), folder / "robot.xml", dry_friction=False)
    mjmodel = mujoco.MjModel.from_xml_path(str(path))
    mjmodel.opt.timestep = STEP
    return mjmodel


@pytest.fixture
def callback():
    yield mujoco.set_mjcb_passive
    mujoco.set_mjcb_passive(None)


@pytest.mark.parametrize(("arm", "names"), CASES)
def test_mujoco_needs_the_models_torque(tmp_path, callback, arm, names):
    model, states = case(arm, names)
    mjmodel = mjmodel_of(model, tmp_path)
    data = mujoco.MjData(mjmodel)
    order = [mjmodel.joint(name).dofadr[0] for name in model.robot.joint_names]
    callback(PassiveForce(model, mjmodel, sign_width=0.0))
    found = np.empty_like(states.q)
    for k, t in enumerate(states.t):
        data.time = t
        data.qpos[order], data.qvel[order], data.qacc[order] = (
            states.q[k],
            states.dq[k],
            states.ddq[k],
        )
        mujoco.mj_inverse(mjmodel, data)
        found[k] = data.qfrc_inverse[order]
    assert agrees(found, arms_torque(model, states))


@pytest.mark.parametrize(("arm", "names"), CASES)
def test_drake_needs_the_models_torque(arm, names):
    model, states = case(arm, names)
    calibrated = calibrated_robot(model)
    plant = build_simulation_plant(calibrated)
    drive = EffectDrive(model, plant, sign_width=0.0, step=STEP)
    order = [plant.GetJointByName(name).velocity_start() for name in model.robot.joint_names]
    beside = torque_by_drake(plant, calibrated, states[:10])
    expected, n = np.empty_like(beside), model.robot.n
    for k in range(10):
        expected[k] = arms_torque(model, states[k : k + 1])[0]
        context = drive.CreateDefaultContext()
        state = np.zeros(2 * n)
        state[order], state[n + np.array(order)] = states.q[k], states.dq[k]
        drive.GetInputPort("state").FixValue(context, state)
        drive.GetInputPort("torque").FixValue(context, expected[k])
        beside[k] += expected[k] - np.asarray(drive.get_output_port().Eval(context))[order]
    assert agrees(beside, expected)


def test_what_cannot_act_is_named_with_its_reason():
    model, _ = model_with(*EFFECTS, duration=0.4)
    left = not_simulated(model)
    assert {item.name for item in left} == MEASURED
    assert all(item.reason for item in left)
    assert len({item.reason for item in left}) == 3


def test_three_simulations_move_alike(tmp_path, callback):
    """A free fall with friction that has a memory, by Drake, by MuJoCo and by the model's own equation."""
    robot = vertical_arm().with_limits(JointLimits.unlimited(2))
    model, _ = model_with("presliding_hysteresis", "joint_spring", robot=robot, duration=0.4)
    step, steps, start = 2e-4, 1000, np.array([0.4, -0.3])
    mjmodel = mjmodel_of(model, tmp_path)
    mjmodel.opt.timestep = step
    data = mujoco.MjData(mjmodel)
    data.qpos[:] = start
    callback(PassiveForce(model, mjmodel))
    for _ in range(steps):
        mujoco.mj_step(mjmodel, data)
    ours = fall(model, start, step, steps)
    assert data.qpos == pytest.approx(ours, abs=1e-3)
    assert drake_fall(model, start, step, steps) == pytest.approx(ours, abs=1e-3)
    assert np.abs(ours - start).max() > 0.05


def fall(model, start, step, steps):
    arm = whole_arm(model, step)
    q, dq, ddq = start.copy(), np.zeros(2), np.zeros(2)
    memory = np.array(arm.begin(q, dq, dq)).ravel()
    for _ in range(steps):
        ddq, memory = arm.acceleration(q, dq, memory, np.zeros(2), start=ddq)
        dq = dq + step * ddq
        q = q + step * dq
    return q


def drake_fall(model, start, step, steps):
    from pydrake.systems.analysis import Simulator  # noqa: PLC0415  where it is used

    diagram, plant = build_simulation(model, step=step)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.GetInputPort("torque").FixValue(context, np.zeros(2))
    plant.SetPositions(plant.GetMyMutableContextFromRoot(context), start)
    simulator.get_mutable_integrator().set_maximum_step_size(step)
    simulator.AdvanceTo(step * steps)
    return np.array(diagram.GetOutputPort("state").Eval(context))[:2]


def test_mujoco_without_memory_of_the_future(tmp_path, callback):
    """A simulation that is set back begins anew."""
    model, states = case("scara", ("presliding_hysteresis",))
    mjmodel = mjmodel_of(model, tmp_path)
    data = mujoco.MjData(mjmodel)
    callback(PassiveForce(model, mjmodel))

    def run():
        mujoco.mj_resetData(mjmodel, data)
        data.qvel[:] = states.dq[0]
        for _ in range(30):
            mujoco.mj_step(mjmodel, data)
        return data.qpos.copy()

    assert run() == pytest.approx(run(), abs=1e-14)


def test_what_mujoco_cannot_do_is_refused(tmp_path):
    model, _ = case("scara", ("presliding_hysteresis",))
    mjmodel = mjmodel_of(model, tmp_path)
    mjmodel.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    with pytest.raises(ValueError, match="RK4"):
        PassiveForce(model, mjmodel)
    other, _ = case("ur5", SOME)
    with pytest.raises(ValueError, match="no joint"):
        PassiveForce(other, mjmodel_of(model, tmp_path))


def test_a_simulation_accelerates_as_the_torque_says():
    model, states = case("scara", ("load_dependent_friction", "stribeck"))
    diagram, plant = build_simulation(model, sign_width=0.0)
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    torque = arms_torque(model, states)
    for k in range(5):
        diagram.GetInputPort("torque").FixValue(context, torque[k])
        plant.SetPositions(plant_context, states.q[k])
        plant.SetVelocities(plant_context, states.dq[k])
        rates = diagram.EvalTimeDerivatives(context).CopyToVector()
        assert np.allclose(rates[2:], states.ddq[k], rtol=1e-8, atol=1e-8)
