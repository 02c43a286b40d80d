"""A gear that yields is driven by the model that has it, not by one that was bent without it."""

import numpy as np
import pytest

from oed.diagnosis.evidence.views import Views
from oed.diagnosis.selection.look_ahead import look_ahead
from oed.diagnosis.selection.screen import evaluate
from oed.diagnosis.selection.tables import Tables, as_term
from oed.diagnosis.setup import pose
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording
from oed.robot.builtin import imi_scara
from tests.diagnosis.arm import COULOMB, INERTIA, NOISE, RATE, VISCOUS
from tests.dynamics.effects.two_mass import Gear, two_mass_torque

BASE = [9, 11, 12, 19]  # Izz_1, mx_2, my_2 and Izz_2
JOINT, GEAR = 1, Gear(7.0, 0.05, 0.3)
WAVES = np.array(
    [0.3, 0.7, 1.3, 2.1, 3.3, 4.7, 6.1, 8.3, 11.0]
)  # [Hz]; the fast ones bend the gear
SETTLED = 3.0  # [s] after which the gear no longer rings of its start
ACCELERATION = 2.0  # [rad/s^2] of each


def _record(name, role, robot, rng):
    t = np.arange(-SETTLED, 20.0, 1 / RATE)
    q, dq, ddq = (np.zeros((len(t), 2)) for _ in range(3))
    for w in 2 * np.pi * WAVES:
        angle = w * t[:, None] + rng.uniform(0, 2 * np.pi, 2)
        q += ACCELERATION / w**2 * np.sin(angle)
        dq += ACCELERATION / w * np.cos(angle)
        ddq -= ACCELERATION * np.sin(angle)
    tau = two_mass_torque(robot, Motion(t, q, dq, ddq), JOINT, GEAR)
    tau = tau + COULOMB * np.sign(dq) + VISCOUS * dq + NOISE * rng.normal(size=q.shape)
    q = q + 1e-5 * rng.normal(size=q.shape)
    seen = t >= 0
    return Recording(name, role, t[seen], q[seen], tau[seen])


@pytest.fixture(scope="module")
def start():
    robot = imi_scara()
    parameters = np.zeros_like(robot.parameters)
    parameters[BASE] = INERTIA
    robot = robot.with_parameters(parameters)
    rng = np.random.default_rng(67)
    recordings = tuple(_record(role, role, robot, rng) for role in ("estimation", "validation"))
    dataset = DataSet("arm", "test", "none", imi_scara(), "measured", recordings=recordings)
    model = TorqueModel.standard(dataset.robot)
    problem, _, _ = pose(dataset, model, names=("joint_elasticity",))
    return Views.of(problem, (), "fitted")


@pytest.fixture(scope="module")
def found(start):
    tables = Tables.of(start, start.problem.candidates)
    return look_ahead(tables, start, lambda _: None, lambda: False)


def test_its_shapes_predict_as_well_as_those_of_the_gear(start, found):
    (term,) = found.terms
    assert term.label == f"joint_elasticity@{JOINT + 1}"
    assert term.values[0] == pytest.approx(GEAR.frequency, rel=0.01)
    shapes = (GEAR.frequency, GEAR.damping, GEAR.rotor, 0.0, 0.0)
    scored = evaluate(term.candidate, shapes, start.showing(term.candidate))
    assert scored is not None
    true = start.grown((as_term(scored),), "fitted")
    assert (true.left("held_out") < 0.1 * start.left("held_out")).all()
    assert (found.left("held_out") < 1.5 * true.left("held_out")).all()


def test_it_is_driven_by_the_torque_of_the_model_that_has_it(start, found):
    (gear,) = found.told.installed.measurement
    own, other = found.told.parameters[BASE], start.told.parameters[BASE]
    driving = gear.reference.robot.parameters[BASE]
    np.testing.assert_allclose(driving, own, rtol=0.02)
    assert np.abs(other / own - 1).max() > 0.2
