"""Estimates of the paper's study from sums over rows, against least squares on the rows."""

import numpy as np
import pytest

from oed.estimation.least_squares import batch_least_squares
from oed.experiment.imi_laboratory import ImiLaboratory
from oed.experiment.paper_signals import SampledRuns
from studies.paper_experiment import designs, searches
from studies.paper_experiment.campaign import Conditions, OnArm
from studies.paper_experiment.fitness import LinearCondition
from studies.paper_experiment.fitting import EXTRA, PLAIN, RICH, XI, Sums, infeasible, regressor
from studies.paper_experiment.laboratory import LaboratoryConfig
from studies.paper_experiment.searches import DesignConfig, paper_class, problem
from studies.paper_experiment.stage_cache import StageCache

VARIANCES = np.array([0.04, 0.01])


@pytest.fixture(scope="module")
def columns():
    spec = paper_class(7.0, 3)
    motion = spec.motion(spec.draw(np.random.default_rng(0)), spec.instants(80))
    return regressor(motion)


def recorded(columns, parameters, noise, seed=1):
    rng = np.random.default_rng(seed)
    clean = columns @ parameters
    tau = clean + noise * np.sqrt(VARIANCES) * rng.normal(size=(3, *clean.shape))
    return SampledRuns(np.broadcast_to(columns, (3, *columns.shape)), tau, tau)


def test_sums_give_what_the_rows_give(columns):
    truth = np.concatenate([ImiLaboratory().truth(), np.zeros(len(EXTRA))])
    runs = recorded(columns, truth, 1.0)
    own = runs.columns[..., :XI].reshape(-1, XI)
    expected = batch_least_squares(own, runs.tau.ravel(), 2, noise=VARIANCES)
    sums = Sums.of(runs)
    xi, covariance = sums.fit(VARIANCES, PLAIN)
    np.testing.assert_allclose(xi[:XI], expected.parameters, rtol=1e-8)
    np.testing.assert_allclose(covariance, expected.covariance, rtol=1e-7)
    residual = runs.tau - runs.columns @ xi
    np.testing.assert_allclose(sums.squared_residual(xi), (residual**2).mean(axis=(0, 1)))
    share = np.sqrt((residual**2).mean(axis=(0, 1)) / (runs.tau**2).mean(axis=(0, 1)))
    np.testing.assert_allclose(sums.relative(np.stack([xi, xi]))[1], share)


@pytest.mark.parametrize("own", RICH)
def test_richer_friction_takes_the_speeds_that_the_rows_have(columns, own):
    truth = np.zeros(columns.shape[2])
    truth[:XI] = ImiLaboratory().truth()
    truth[list(own[XI:])] = [1.0, 2.0, 0.5, 0.4]
    found = Sums.of(recorded(columns, truth, 1e-4)).fit_rich(VARIANCES)
    np.testing.assert_allclose(found, truth, atol=2e-3)


def test_an_arm_that_cannot_be_is_told():
    good = ImiLaboratory().truth()
    assert not infeasible(good)
    for index, value in ((0, -1.0), (1, 30.0), (3, -0.1), (4, -0.2)):
        bad = good.copy()
        bad[index] = value
        assert infeasible(bad)


def test_the_paper_s_fitness_is_the_condition_itself():
    spec = problem(paper_class(7.0, 3), "J_k", 80)
    z = spec.random_start(np.random.default_rng(0))
    eigenvalues = np.linalg.eigvalsh(spec.information(z))
    expected = eigenvalues[-1] / eigenvalues[0]
    np.testing.assert_allclose(LinearCondition(spec).cost(z), expected, rtol=1e-9)


def test_a_search_is_converged_where_no_bit_improves_it(tmp_path):
    config = DesignConfig(bits=1, terms=1, population=8, generations=25)
    (found,) = searches.search(StageCache(tmp_path), searches.runs_of(config, 7.0, "J_d", 1))
    spec = problem(paper_class(7.0, 1), "J_d", config.samples)
    lower, upper = spec.trajectory.bounds.T
    genotypes = np.array(np.meshgrid(*[[0, 1]] * spec.size)).reshape(spec.size, -1).T
    values = np.array([-spec.cost(lower + g * (upper - lower)) for g in genotypes])
    best = genotypes[np.argmax(values)]
    near = values[np.abs(genotypes - best).sum(axis=1) == 1].max()
    z = lower + best * (upper - lower)
    np.testing.assert_allclose(designs.best_neighbour(spec, z, 1), near)
    # Sixteen genotypes, two hundred looks: the algorithm ends at the best of all.
    np.testing.assert_allclose(found.best[0, -1], values.max())


def test_every_motion_on_the_arm_has_a_noise_of_its_own():
    laboratory = LaboratoryConfig(repetitions=1)
    gains = laboratory.laboratory.controller()
    bench = (tuple(gains.stiffness), tuple(gains.damping), (1.0, 0.3))
    conditions = Conditions(laboratory, bench, draws=2, horizon=0.1, terms=1)
    z = tuple(paper_class(0.1, 1).draw(np.random.default_rng(0)).tolist())
    first, again, other = (
        OnArm(conditions, 0, draw, z).record(1) for draw in ((2, 0, 0), (2, 0, 0), (2, 0, 1))
    )
    assert first.q.shape[-1] == 2  # one repetition for each draw of the noise
    assert np.array_equal(first.command, again.command)
    assert not np.isclose(first.command, other.command).all()
