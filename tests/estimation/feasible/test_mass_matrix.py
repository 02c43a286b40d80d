import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

from oed.dynamics.drake_plant import build_plant, coordinate_order
from oed.dynamics.models import build_model
from oed.estimation.feasible.mass_matrix import (
    mass_matrices,
    random_poses,
    share_positive_definite,
)
from tests.estimation.feasible.cases import random_tree, small_model, true_parameters


def drake_mass_matrix(plant: MultibodyPlant, robot, q):
    context = plant.CreateDefaultContext()
    order = coordinate_order(plant, robot)
    positions = np.zeros(robot.n)
    positions[order] = q
    plant.SetPositions(context, positions)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape
    return plant.CalcMassMatrix(context)[np.ix_(order, order)]


def test_agrees_with_drake_on_a_tree():
    rng = np.random.default_rng(1)
    model = build_model("standard", random_tree(6, rng))
    parameters = true_parameters(model, rng)
    q = random_poses(model, 5, rng)
    plant = build_plant(model.robot)
    for pose, matrix in zip(q, mass_matrices(model, parameters, q), strict=True):
        assert np.allclose(matrix, drake_mass_matrix(plant, model.robot, pose), atol=1e-10)


def test_rotors_stand_on_the_diagonal():
    model = small_model()
    parameters = true_parameters(model, np.random.default_rng(2))
    without = parameters.copy()
    rotors = [k for k, p in enumerate(model.parameters) if p.name.startswith("Ia_")]
    without[rotors] = 0.0
    q = random_poses(model, 2, np.random.default_rng(3))
    added = mass_matrices(model, parameters, q) - mass_matrices(model, without, q)
    assert np.allclose(added, np.diag(parameters[rotors]))


def test_counts_the_matrices_that_are_not_definite():
    matrices = np.array([np.eye(2), np.diag([1.0, -1.0]), np.eye(2), np.zeros((2, 2))])
    assert share_positive_definite(matrices) == pytest.approx(0.5)


def test_consistent_links_make_definite_matrices():
    rng = np.random.default_rng(4)
    model = build_model("standard", random_tree(5, rng))
    q = random_poses(model, 200, rng)
    assert share_positive_definite(mass_matrices(model, true_parameters(model, rng), q)) == 1.0
