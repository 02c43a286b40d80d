"""Weight of the pull by cross-validation, and intervals by resampling blocks."""

import numpy as np
import pytest

from oed.dynamics.motion import random_motion
from oed.estimation.feasible import cross_validation
from oed.estimation.feasible.bootstrap import MOSTLY_DATA, Bootstrap, bootstrap, interval_about
from oed.estimation.feasible.cross_validation import choose_weight, cross_validate
from oed.estimation.feasible.data_factor import DataFactor, JointFactors
from oed.estimation.feasible.estimate import estimate_feasible
from oed.estimation.feasible.feasible_set import FeasibleSet, least_values
from oed.estimation.feasible.interior import SolverFailed
from oed.estimation.feasible.problem import build_problem
from oed.estimation.feasible.regularisation import Regularisation
from oed.estimation.feasible.reweighting import log_rms, solve_reweighted
from tests.estimation.feasible.cases import data_of, joints_of, small_model, true_parameters

NOISE = 3.0
VARIANCES = np.full(3, NOISE**2)
WEIGHTS = (1e-6, 1e-3, 1.0)


def weighted(pieces):
    return [piece.weighted(VARIANCES) for piece in pieces]


def blocks_and_estimate(prior_of, blocks=6, samples=8):
    rng = np.random.default_rng(21)
    model = small_model()
    truth = true_parameters(model, rng)
    pieces = [joints_of(model, truth, rng, samples=samples, noise=NOISE) for _ in range(blocks)]
    estimate = estimate_feasible(
        model,
        JointFactors.join(pieces).weighted(VARIANCES),
        prior=prior_of(model.robot.parameters),
        regularisation=Regularisation(1e-3),
    )
    return pieces, estimate, truth


def test_a_true_prior_is_trusted_and_a_wrong_one_is_not():
    pieces, estimate, _ = blocks_and_estimate(lambda true: true)
    trusted = cross_validate(estimate.problem, pieces, VARIANCES, weights=WEIGHTS, folds=3)
    assert trusted.weight == 1.0
    # With more data, because from little it cannot be told that a prior is wrong.
    pieces, estimate, _ = blocks_and_estimate(lambda true: 5 * true, samples=60)
    doubted = cross_validate(estimate.problem, pieces, VARIANCES, weights=WEIGHTS, folds=3)
    assert doubted.weight < 1.0
    assert doubted.mean[-1] > doubted.mean[doubted.best]


def test_the_chosen_weight_is_no_smaller_than_the_best():
    pieces, estimate, _ = blocks_and_estimate(lambda true: true)
    curve = cross_validate(estimate.problem, pieces, VARIANCES, weights=WEIGHTS, folds=3)
    assert curve.chosen >= curve.best
    assert curve.held_out.shape == (3, 3)
    assert np.all(curve.mean >= curve.mean[curve.best])
    # With little data, demands and pull predict better than least squares alone.
    assert curve.mean[curve.best] < curve.least_squares.mean()


def test_a_flat_curve_leaves_the_choice_to_the_stronger_pull():
    weights = np.array([1e-7, 1e-3, 1e-1, 1.0])
    # 2.795 and 2.806 as of a measured arm, each fold alike: significant, and not worth a thing.
    errors = np.array([2.795, 2.806, 2.80, 3.2])[:, None] * np.array([0.9, 1.0, 1.1])
    assert choose_weight(weights, np.log(errors)) == (0, 2)
    # Two per cent is worth it where every fold agrees, and not where they differ by more.
    errors[1:3] *= 1.02
    assert choose_weight(weights, np.log(errors)) == (0, 0)
    errors[1:3] *= np.array([0.95, 1.0, 1.05])
    assert choose_weight(weights, np.log(errors)) == (0, 2)
    # A weight that a fold has no solution with is passed over.
    errors[2, 1] = np.nan
    assert choose_weight(weights, np.log(errors)) == (0, 1)


def test_the_ladder_goes_on_past_a_weight_that_no_solver_solves(monkeypatch):
    pieces, estimate, _ = blocks_and_estimate(lambda true: true)
    solve = cross_validation.solve_reweighted

    def fails_at_the_first(problem, *given, **named):
        if problem.regularisation.weight == WEIGHTS[0]:
            raise SolverFailed("no solution", ("made to fail",))
        return solve(problem, *given, **named)

    monkeypatch.setattr(cross_validation, "solve_reweighted", fails_at_the_first)
    curve = cross_validate(estimate.problem, pieces, VARIANCES, weights=WEIGHTS, folds=2)
    assert curve.unsolved == (WEIGHTS[0],)
    assert curve.chosen in {1, 2}


def test_weights_are_those_that_the_feasible_estimate_itself_leaves():
    rng = np.random.default_rng(24)
    model = small_model()
    truth = true_parameters(model, rng)
    motion = random_motion(model.robot, 2000, rng)
    noise = np.array([0.2, 1.0, 5.0])
    torque = model.torque(truth, motion) + noise * rng.standard_normal((2000, 3))
    data = JointFactors.of(model.columns(motion), torque)
    problem = build_problem(
        model,
        data.weighted(np.ones(3)),
        FeasibleSet.of(model),
        model.robot.parameters,
        Regularisation(1e-5),
    )
    fit = solve_reweighted(problem, data, np.ones(3))
    assert np.allclose(np.sqrt(fit.variances), noise, rtol=0.06)
    assert np.allclose(fit.variances, data.variances(fit.parameters), rtol=1e-3)
    # What is minimised falls at each solve: the concentrated likelihood's exponent.
    ones = np.ones(3)
    steps = [solve_reweighted(problem, data, ones, solves=k).parameters for k in (1, 2, 3)]
    errors = [log_rms(data, step, ones) for step in steps]
    assert errors[0] >= errors[1] - 1e-9
    assert errors[1] >= errors[2] - 1e-9


def test_few_blocks_are_left_out_in_as_many_folds():
    pieces, estimate, _ = blocks_and_estimate(lambda true: true, blocks=2)
    curve = cross_validate(estimate.problem, pieces, VARIANCES, weights=WEIGHTS, folds=5)
    assert curve.held_out.shape == (3, 2)
    with pytest.raises(ValueError, match="1 blocks"):
        cross_validate(estimate.problem, pieces[:1], VARIANCES, folds=5)


def test_resamples_are_feasible_and_repeatable():
    pieces, estimate, _ = blocks_and_estimate(lambda true: 1.2 * true)
    first, again = (
        bootstrap(estimate, weighted(pieces), np.random.default_rng(5), resamples=6)
        for _ in range(2)
    )
    assert np.array_equal(first.samples, again.samples)
    assert first.failures == 0
    for sample in first.samples:
        x = estimate.problem.coordinates.unknowns(sample)
        assert estimate.problem.link_margins(x).min() > estimate.problem.margin - 1e-7
        assert estimate.problem.slack(x).min() > -1e-7
    interval = first.interval()
    measured = estimate.from_data > MOSTLY_DATA
    assert measured.any()
    assert np.array_equal(np.isfinite(interval).all(axis=1), measured)
    assert np.all(interval[measured, 0] <= interval[measured, 1])


@pytest.mark.parametrize("draws", [2, 3, 38, 39, 60])
def test_an_interval_holds_its_estimate_and_as_many_further_draws_as_it_says(draws):
    rng = np.random.default_rng(7)
    inside = []
    for _ in range(2000):
        *samples, further = rng.standard_normal(draws + 1)
        for estimate in (0.0, 3.0):
            low, high = interval_about(np.array([estimate]), np.array(samples)[:, None], 0.95)[0]
            assert low <= estimate <= high
            if estimate == 0.0:
                inside.append(low <= further <= high)
    # 0.95, within four standard deviations of 2000 draws; about a known centre a little more.
    assert 0.95 - 0.02 < np.mean(inside) < 0.98
    with pytest.raises(ValueError, match="level"):
        interval_about(np.zeros(1), np.zeros((3, 1)), 1.0)


def test_intervals_cover_well_determined_parameters():
    pieces, estimate, truth = blocks_and_estimate(lambda true: true, blocks=12, samples=40)
    spread = bootstrap(estimate, weighted(pieces), np.random.default_rng(6), resamples=12)
    names = list(estimate.names)
    viscous = [names.index(f"Fv_{j}") for j in (1, 2, 3)]
    assert np.all(np.abs(estimate.parameters - truth)[viscous] < 4 * spread.std[viscous])
    assert np.all(estimate.from_data[viscous] > 0.99)


def test_parameters_at_a_bound_are_marked_because_their_intervals_have_no_width():
    rng = np.random.default_rng(22)
    model = small_model()
    truth = true_parameters(model, rng)
    names = [parameter.name for parameter in model.parameters]
    k = names.index("Fv_2")
    truth[k] = -2.0  # such as a friction that a faulty sensor reverses
    pieces = [data_of(model, truth, rng, samples=60, noise=0.3) for _ in range(4)]
    estimate = estimate_feasible(
        model, DataFactor.join(pieces), regularisation=Regularisation(1e-3)
    )
    # Coulomb friction goes with it: it would stand in for the viscous one's sign.
    marked = {f"{n} >= 0" for n, held in zip(names, estimate.at_bound, strict=True) if held}
    assert "Fv_2 >= 0" in marked
    assert marked == set(estimate.active)
    lower, upper = bootstrap(estimate, pieces, rng, resamples=6).interval()[k]
    assert upper - lower < 1e-3  # although noise alone moves it by far more
    assert estimate.from_data[k] > 0.9


def test_every_parameter_of_a_link_at_its_bound_is_marked():
    rng = np.random.default_rng(23)
    model = small_model()
    truth = true_parameters(model, rng)
    truth[20:30] *= [1, 1, 1, 1, -1, 1, 1, -1, 1, -1]  # no body has such moments
    estimate = estimate_feasible(
        model, data_of(model, truth, rng), regularisation=Regularisation(1e-8)
    )
    assert "consistency of link_3" in estimate.active
    assert estimate.at_bound[20:30].all()
    rows = [f"{n} >= 0" in estimate.active for n in estimate.names[30:]]
    assert estimate.at_bound[30:].tolist() == rows


def test_refuses_to_resample_one_block():
    pieces, estimate, _ = blocks_and_estimate(lambda true: true)
    with pytest.raises(ValueError, match="1 block"):
        bootstrap(estimate, weighted(pieces[:1]), np.random.default_rng(0))


def test_intervals_beside_a_wrong_prior_hold_the_truth_as_often_as_they_say():
    """All masses of the prior are off by up to 60 %; half to nearly all of a value is the data's."""
    model, draws = small_model(), 25
    inside, as_resampled = [], []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        truth = true_parameters(model, rng)
        prior = truth[:30].reshape(3, 10) * rng.uniform(0.6, 1.6, (3, 1))
        motion = random_motion(model.robot, 300, rng)
        clean, columns = model.torque(truth, motion), model.regressor(motion)
        noise = 0.05 * np.sqrt(np.mean(clean**2))
        for weight in (1e-5, 1e-4, 1e-3):
            found = []
            for _ in range(draws):
                noisy = clean + noise * rng.standard_normal(clean.shape)
                data = DataFactor.of(columns, noisy, np.full(3, noise**2))
                pull = Regularisation(weight)
                found.append(
                    estimate_feasible(model, data, prior=prior.ravel(), regularisation=pull)
                )
            values = np.array([e.parameters for e in found])
            for estimate in found:
                own = (estimate.from_data > 0.5) & (estimate.from_data < 0.95)
                samples = estimate.parameters + values - values.mean(axis=0)
                spread = Bootstrap(
                    estimate.parameters, samples, estimate.from_data, least_values(model), 0, ""
                )
                bare = interval_about(estimate.parameters, samples, 0.95)
                for interval, held in ((spread.interval(), inside), (bare, as_resampled)):
                    held.extend(_holds(interval, truth)[own].tolist())
    assert len(inside) > 2000
    assert 0.92 < np.mean(inside) < 0.98
    assert np.mean(as_resampled) < 0.9  # what this mends


def _holds(interval, truth):
    return (interval[:, 0] <= truth) & (truth <= interval[:, 1])


def test_no_interval_passes_what_a_body_or_an_effect_can_be():
    model = small_model()
    least = least_values(model)
    names = [p.name for p in model.parameters]
    of = dict(zip(names, least, strict=True))
    assert of["m_1"] == of["Izz_3"] == of["Fc_2"] == of["Ia_1"] == 0.0
    assert of["mx_1"] == of["Ixy_2"] == -np.inf
    value = np.full(len(names), 1.0)
    samples = np.linspace(0.2, 1.8, 45)[:, None] * np.ones(len(names))
    wide = Bootstrap(value, samples, np.full(len(names), 0.51), least, 0, "").interval()
    assert wide[names.index("m_1"), 0] == 0.0
    assert wide[names.index("mx_1"), 0] < -0.4


def test_what_the_data_do_not_decide_has_no_interval():
    samples = np.array([[1.0, 2.0], [1.2, 2.0], [0.8, 2.0]])
    least = np.full(2, -np.inf)
    spread = Bootstrap(np.array([1.0, 2.0]), samples, np.array([0.8, 0.4]), least, 0, "")
    assert np.isnan(spread.interval()[1]).all()
    assert np.isfinite(spread.interval()[0]).all()
