import numpy as np
import pytest

from oed.dynamics.identifiability import base_parameters
from oed.estimation.feasible.base_feasibility import base_feasibility
from oed.estimation.feasible.coordinates import Coordinates
from oed.estimation.feasible.reference import neutral_bodies
from tests.estimation.feasible.cases import small_model, true_parameters


@pytest.fixture(scope="module")
def arm():
    model = small_model()
    return model, base_parameters(model), true_parameters(model, np.random.default_rng(1))


def test_base_parameters_of_a_robot_have_one(arm):
    model, base, truth = arm
    light = 0.1 * truth  # so that the margin is below one, where it is not looked for further
    found = base_feasibility(model, base, base.from_standard(light))
    assert found.is_feasible
    assert 0 < found.margin < 1
    assert np.allclose(base.from_standard(found.example), base.from_standard(light), atol=1e-6)
    effects = np.ones(len(truth) - 30)
    coordinates = Coordinates.relative_to(neutral_bodies(model.robot), effects)
    inertias = coordinates.relative_inertias(coordinates.unknowns(found.example))
    assert np.linalg.eigvalsh(inertias).min() == pytest.approx(found.margin, abs=1e-7)


def test_the_truth_is_no_deeper_inside_than_the_example(arm):
    model, base, truth = arm
    light = 0.1 * truth
    found = base_feasibility(model, base, base.from_standard(light))
    coordinates = Coordinates.relative_to(neutral_bodies(model.robot), np.ones(len(truth) - 30))
    own = np.linalg.eigvalsh(coordinates.relative_inertias(coordinates.unknowns(light))).min()
    assert own <= found.certificate.bound + 1e-7
    assert found.margin == pytest.approx(found.certificate.bound, abs=1e-6)


def test_an_impossible_link_is_proven_so_and_named(arm):
    model, base, truth = arm
    broken = truth.copy()
    broken[24:30] *= -1.0  # the last link's inertia, which no other link can make up for
    values = base.from_standard(broken)
    found = base_feasibility(model, base, values)
    assert not found.is_feasible
    assert found.blamed[0] == model.robot.joints[2].link
    proof = found.certificate
    assert proof.bound < 0
    assert proof.residual < 1e-6
    assert proof.links.sum() + proof.inequality.sum() == pytest.approx(1.0)


def test_negative_friction_is_named(arm):
    model, base, truth = arm
    wrong = truth.copy()
    column = [p.name for p in model.parameters].index("Fv_2")
    wrong[column] = -0.3
    found = base_feasibility(model, base, base.from_standard(wrong))
    assert not found.is_feasible
    assert found.blamed == ("Fv_2 >= 0",)


def test_a_joint_without_friction_is_feasible(arm):
    model, base, truth = arm
    free = truth.copy()
    free[[p.name for p in model.parameters].index("Fc_1")] = 0.0
    assert base_feasibility(model, base, base.from_standard(free)).is_feasible
