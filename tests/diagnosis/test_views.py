"""Which rows tell of a model: the mean of repetitions, and what differs between them."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.evidence.model import fit
from oed.diagnosis.evidence.views import Views, chosen
from oed.diagnosis.selection.screen import evaluate
from oed.diagnosis.selection.tables import as_term
from oed.diagnosis.setup import pose
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import INERTIA, data_set

BASE = [9, 11, 12, 19]  # columns of the arm's four base inertias in the standard model


def _posed(dataset, *names):
    return pose(dataset, TorqueModel.standard(dataset.robot), names=names or ("stribeck",))[0]


def test_numbers_are_those_of_the_mean_which_noise_of_the_motion_hardly_biases():
    problem = _posed(data_set(7, repetitions=6, wander=0.3))
    views = Views.of(problem, (), "all")
    of_all_rows = fit(problem, (), chosen(problem, "all"))
    off = [
        np.abs(fitted.parameters[BASE] / INERTIA - 1).max()
        for fitted in (views.told, views.every, of_all_rows)
    ]
    assert off[0] < 0.01
    assert off[1] < 0.1  # what changes is told by all rows beside it
    assert off[2] > 0.3


def test_a_term_that_changes_between_repetitions_is_told_by_all_of_them():
    problem = _posed(data_set(7, repetitions=3), "thermal_drift", "stribeck")
    start = Views.of(problem, (), "fitted")
    for name, told in (("thermal_drift@1", "every"), ("stribeck@1", "means")):
        candidate = next(c for c in problem.names if c.label == name)
        tried = (
            evaluate(candidate, values, start.showing(candidate))
            for values in candidate.grid(problem.context)
        )
        grown = start.grown((as_term(next(s for s in tried if s is not None)),), "fitted")
        assert grown.told is getattr(grown, told)


def test_what_is_explained_of_differences_is_no_gain_and_what_is_added_to_them_neither():
    problem = _posed(data_set(7, repetitions=4, wander=0.3))
    first = Views.of(problem, (), "fitted")
    # Means as before beside twice the torque of each repetition: more of differences is left.
    rows = dataclasses.replace(problem.rows, torque=2 * problem.rows.torque)
    louder = Views.of(dataclasses.replace(problem, rows=rows), (), "fitted")
    worse = dataclasses.replace(louder, first=first)
    assert (louder.apart("fitted") > first.apart("fitted")).all()
    assert worse.left("fitted") == pytest.approx(first.left("fitted"))
    better = dataclasses.replace(first, first=louder)
    fallen = louder.apart("fitted") - first.apart("fitted")
    assert better.left("fitted") == pytest.approx(first.left("fitted") + fallen)


def test_what_is_alike_is_its_mean_over_repetitions_and_nothing_is_lost():
    problem = _posed(data_set(7, repetitions=3), "thermal_drift", "stribeck")
    start = Views.of(problem, (), "fitted")
    law = next(c for c in problem.names if c.label == "stribeck@1")
    tried = (evaluate(law, shapes, start.means) for shapes in law.grid(problem.context))
    grown = start.grown((as_term(next(s for s in tried if s is not None)),), "fitted")
    design, found = grown.every.design, grown.means.projection.coefficients
    columns, told = design.alike(found)
    base, (place,) = len(design.visible), design.places
    for phase in np.unique(problem.rows.phase)[::40]:
        rows = problem.rows.phase == phase
        for part in (slice(base), place):
            mean = design.columns[:, rows, part].mean(axis=1, keepdims=True)
            assert columns[:, rows, part] == pytest.approx(
                np.broadcast_to(mean, (2, rows.sum(), mean.shape[2]))
            )
    rest = columns[:, :, -base:]
    assert columns[:, :, :base] + rest == pytest.approx(design.columns[:, :, :base])
    apart = design.columns[:, :, place] - columns[:, :, place]
    assert told == pytest.approx(apart @ found[place])
    # What the fit to all rows explains is what is alike, and that.
    left = problem.rows.torque - told - columns @ grown.every.projection.coefficients
    assert grown.every.projection.residual == pytest.approx(left, abs=1e-9)
    assert np.abs(told).max() > 1e-3


def test_what_noise_leaves_of_a_row_is_one_of_means_and_of_differences():
    views = Views.of(_posed(data_set(7, repetitions=4)), (), "fitted")
    for which in ("fitted", "held_out"):
        assert views.apart(which) == pytest.approx([1.0, 1.0], abs=0.25)
        assert views.left(which) == pytest.approx([1.0, 1.0], abs=0.25)
