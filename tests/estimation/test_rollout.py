"""A simulated model moves as the arm moved whose model it is; Drake moved the arm."""

import dataclasses

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from oed.dynamics.effects import Coulomb, RigidBody
from oed.dynamics.effects.actuator import TorqueGain
from oed.dynamics.effects.delay import TimeDelay
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.estimation import rollout_fit
from oed.estimation.rollout import ImplicitArm, NotSimulated, Track, last_origin, roll_out
from oed.estimation.rollout_fit import refine_by_rollout
from oed.estimation.symbolic_bodies import possible_bodies
from oed.export.simulation_plant import build_simulation
from oed.robot import JointLimits
from oed.robot.inertia import pseudo_inertia
from tests.dynamics.effects.arms import panda, vertical_arm
from tests.export.every_effect import model_with

RATE, SECONDS = 200.0, 4.0  # [Hz], [s] of the recording
WIDTH = 0.02  # [rad/s] of every sign
HORIZONS = (0.1, 0.5, 1.0, 2.0)


@pytest.fixture(scope="module")
def recorded():
    """A sprung arm with Stribeck friction under smooth torques, simulated by Drake."""
    robot = vertical_arm().with_limits(JointLimits.unlimited(2))
    model, _ = model_with("joint_spring", "stribeck", robot=robot, duration=0.4)
    diagram, plant = build_simulation(model, sign_width=WIDTH)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    start = np.array([-1.4, 0.2])
    plant.SetPositions(plant.GetMyMutableContextFromRoot(context), start)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
    t = np.arange(0.0, SECONDS, 1 / RATE)
    tau = np.stack([6 * np.sin(3 * t), 2 * np.cos(5 * t)], axis=1)
    q, dq = np.empty_like(tau), np.empty_like(tau)
    for k, now in enumerate(t):
        state = np.asarray(diagram.GetOutputPort("state").Eval(context))
        q[k], dq[k] = state[:2], state[2:]
        diagram.GetInputPort("torque").FixValue(context, tau[k])
        simulator.AdvanceTo(now + 1 / RATE)
    held = np.repeat(tau, 10, axis=0)  # each set point holds until the next
    fine = (np.arange(len(held)) / (10 * RATE))[1:]
    motion = Motion(t, q, dq, np.gradient(dq, t, axis=0))
    return model, Track(motion, fine, held[:-1])


def test_moves_as_drake_moved(recorded):
    model, track = recorded
    found = roll_out(model.torque_model, model.parameters, [track], windows=1, sign_width=WIDTH)
    assert found.windows == 1
    assert found.lost == 0
    travelled = np.ptp(track.motion.q, axis=0).max()
    assert travelled > 0.3
    assert found.joint[-1].max() < 0.01 * travelled


def test_the_error_of_a_step_is_of_first_order(recorded):
    model, track = recorded
    ends = {}
    for step in (4e-3, 2e-3, 1e-3):
        arm = ImplicitArm.of(model.torque_model, model.parameters, step, WIDTH)
        ends[step] = arm.follow(track, 100, HORIZONS[:2])[-1]
    halved = np.abs(ends[2e-3] - ends[1e-3]).max() / np.abs(ends[4e-3] - ends[2e-3]).max()
    assert 0.4 < halved < 0.65


def test_a_model_that_lacks_the_spring_drifts(recorded):
    model, track = recorded
    lacking = model.parameters.copy()
    names = [p.name for p in model.torque_model.parameters]
    lacking[names.index("spring_2")] = 0.0
    whole, without = (
        roll_out(model.torque_model, p, [track], step=4e-3, windows=1)
        for p in (model.parameters, lacking)
    )
    assert without.flange[-1] > 5 * whole.flange[-1]
    assert (np.diff(without.flange) > 0).all()


def test_a_joint_that_sticks_stays(recorded):
    _, track = recorded
    robot = vertical_arm()
    effects = (RigidBody(robot), Coulomb(0, 1e-3), Coulomb(1, 1e-3))
    parameters = np.concatenate([robot.parameters, [100.0, 100.0]])
    still = Motion(track.motion.t, *(np.zeros_like(track.motion.q) for _ in range(3)))
    stuck = Track(still, track.t, np.zeros_like(track.tau))
    found = roll_out(TorqueModel(robot, effects), parameters, [stuck], step=1e-3, windows=1)
    # It creeps at the share of the sign's width that holds the weight.
    assert found.joint[-1].max() < 2.0 * 1e-3


def test_what_measurement_did_to_the_torque_is_undone(recorded):
    model, track = recorded
    late, weak = 0.03, 0.8
    seen = track.tau * [weak, 1.0]
    seen = np.stack([np.interp(track.t - late, track.t, own) for own in seen.T], axis=1)
    recording = Track(track.motion, track.t, seen)
    whole = model.torque_model
    gain = TorqueGain(0, weak, 0.0, ReferenceTorque(whole.robot))
    measured = dataclasses.replace(whole, measurement=(gain, TimeDelay(late)))
    known, unknown = (
        roll_out(m, model.parameters, [recording], step=2e-3, windows=1, sign_width=WIDTH)
        for m in (measured, whole)
    )
    assert known.flange[-1] < 0.02 * unknown.flange[-1]


def test_bodies_that_do_not_exist_are_not_simulated(recorded):
    model, track = recorded
    names = [p.name for p in model.torque_model.parameters]
    none = model.parameters.copy()
    none[names.index("Izz_2")] = -0.1
    with pytest.raises(NotSimulated, match="eigenvalue -"):
        roll_out(model.torque_model, none, [track], step=2e-3)


def test_one_window_in_a_few_that_leaves_the_arm_does_not_decide(recorded):
    model, track = recorded
    thrown = Track(track.motion, track.t, track.tau + 1e4)
    found = roll_out(
        model.torque_model, model.parameters, [track, thrown, track], windows=1, step=2e-3
    )
    assert (found.windows, found.lost) == (3, 1)
    assert found.flange[-1] < 0.01


def test_a_simulation_that_leaves_the_arm_is_counted(recorded):
    model, track = recorded
    wrong = model.parameters.copy()
    wrong[model.torque_model.robot.n * 10 :] *= -20  # friction that drives
    found = roll_out(model.torque_model, wrong, [track], step=2e-3, windows=1)
    assert found.lost == 1
    assert found.flange[-1] == 10.0


def test_a_recording_that_is_too_short_is_refused(recorded):
    model, track = recorded
    short = Track(track.motion[:300], track.t, track.tau)
    with pytest.raises(ValueError, match="as long as 2 s"):
        roll_out(model.torque_model, model.parameters, [short])


def test_the_last_links_origin_is_where_trigonometry_has_it():
    robot = vertical_arm()
    q = np.array([[0.3, -1.0], [2.0, 0.5]])
    length = robot.joints[1].p_PJ[0]
    expected = length * np.stack([np.cos(q[:, 0]), np.sin(q[:, 0]), np.zeros(2)], axis=1)
    assert last_origin(robot, q) == pytest.approx(expected)


def test_a_fit_of_simulations_finds_the_parameters_that_moved_the_arm(recorded, monkeypatch):
    monkeypatch.setattr(rollout_fit, "MOST_WINDOWS", 6)
    model, track = recorded
    names = [p.name for p in model.torque_model.parameters]
    true = model.parameters
    unsure = [names.index(x) for x in ("mx_2", "spring_2", "Fv_1")]
    half = np.zeros((len(names), len(unsure)))
    half[unsure, range(3)] = 0.3 * np.abs(true[unsure])
    off = np.array([-1.0, -1.0, 1.0])
    weights = np.eye(len(names))[[names.index("Fv_1")]]
    fit = refine_by_rollout(
        model.torque_model,
        true + half @ off,
        half,
        [track],
        weights=weights,
        bounds=np.zeros(1),
    )
    left = np.abs(fit.shift + off)
    # Six windows, of which each counts as one observation: the prior, which is a deviation off, holds the rest.
    assert np.linalg.norm(left) < 0.5 * np.linalg.norm(off)
    start, end = (
        roll_out(model.torque_model, p, [track], windows=1, sign_width=WIDTH, step=2e-3)
        for p in (true + half @ off, fit.parameters)
    )
    assert end.joint[1].max() < 0.5 * start.joint[1].max()  # after the half second that is fitted


def test_a_fit_keeps_to_bodies_that_can_exist():
    robot = panda()
    column = np.zeros((70, 1))
    column[10] = 1.0  # the second link's mass
    possible = possible_bodies(7, robot.parameters, column, np.zeros((0, 70)), np.zeros(0))
    body = robot.parameters[10:20].copy()
    seen = set()
    for less in (0.0, 0.1, 0.3, 0.6, 0.9, 1.1):
        change = -less * robot.parameters[10]
        body[0] = robot.parameters[10] + change
        exists = bool(np.linalg.eigvalsh(pseudo_inertia(body)).min() > 0)
        assert (np.array(possible(change)).min() > 0) == exists
        seen.add(exists)
    assert seen == {True, False}
