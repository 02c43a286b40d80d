"""The problem of a small arm with noise, for tests of solvers."""

import numpy as np

from oed.estimation.feasible.feasible_set import FeasibleSet
from oed.estimation.feasible.problem import build_problem
from oed.estimation.feasible.reference import (
    scaled_neutral_bodies,
)
from oed.estimation.feasible.regularisation import Regularisation, RegularisationKind
from tests.estimation.feasible.cases import data_of, small_model, true_parameters


def arm_problem(weight=1e-4, kind: RegularisationKind = "entropic", noise=2.0, **demands):
    rng = np.random.default_rng(7)
    model = small_model()
    data = data_of(model, true_parameters(model, rng), rng, noise=noise, samples=40)
    reference = scaled_neutral_bodies(model.robot, data.factor, data.target)
    wanted = FeasibleSet.of(model).with_(**demands)
    return build_problem(model, data, wanted, reference, Regularisation(weight, kind))
