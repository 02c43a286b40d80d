"""What a candidate is worth beside a model: its price, its gain, its rank."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.evidence.columns import white_effect
from oed.diagnosis.evidence.model import fit
from oed.diagnosis.numbers import OUTSIDE, SMOOTHNESS
from oed.diagnosis.selection import tables
from oed.diagnosis.selection.screen import least_price, price, weighed
from oed.diagnosis.selection.table import Line, lay_out, ranked
from oed.diagnosis.setup import pose
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set, stribeck

NAMES = ("stribeck", "torque_offset", "joint_spring", "rotor_inertia", "nonlinear_viscous")
UNEVEN = np.array([1.5, 4.0])  # variance of the joints' rows, of which neither is 1


@pytest.fixture(scope="module")
def problem():
    dataset = data_set(23, repetitions=1, extra=stribeck(1.5))
    return pose(dataset, TorqueModel.standard(dataset.robot), names=NAMES)[0]


@pytest.fixture(scope="module")
def fitted(problem):
    return fit(problem, (), problem.rows.fitted, variance=UNEVEN)


def _named(problem, label):
    return next(c for c in problem.names if c.label == label)


def test_prior_probabilities_of_names_add_up_to_one_and_of_curves_to_what_lies_outside(problem):
    names = [np.exp(-least_price(c, problem)) for c in problem.names]
    curves = [np.exp(-least_price(c, problem)) for c in problem.smooth]
    assert len(names) == 2 * len(NAMES)
    assert sum(names) == pytest.approx(1.0)
    assert len(SMOOTHNESS) * sum(curves) == pytest.approx(OUTSIDE)


@pytest.mark.parametrize("rows", [1e3, 30.0])
def test_a_shape_that_is_estimated_costs_half_the_log_of_the_rows_or_the_log_of_its_values(
    problem, fitted, rows
):
    law = _named(problem, "stribeck@1")
    speed, exponent, tail = law.shapes(problem.context)
    assert (speed.points, exponent.points, tail.plain) == (14, 3, True)
    plain = np.log(2 * len(NAMES))
    own = [max(0.5 * np.log(rows), np.log(points)) for points in (14, 3)]
    assert price(law, (0.1, 2.0, 0.0), fitted, rows) == pytest.approx(plain + sum(own))


def _beside(fitted, candidate, values):
    effect = candidate.effect(fitted.context, values)
    columns = white_effect(effect, fitted.installed, fitted.problem.rows)
    return fitted.projection.beside(columns)


def test_columns_that_explain_nothing_gain_nothing(problem, fitted):
    """Whatever variance the joints' rows have: what is left is as much as before."""
    law, counted = _named(problem, "rotor_inertia@2"), fitted.rows(fitted.projection.used)
    beside = _beside(fitted, law, ())
    silent = dataclasses.replace(beside, scores={j: 0 * x for j, x in beside.scores.items()})
    own = weighed(law, (), fitted, silent, counted)
    assert own is not None
    assert own.nats == pytest.approx(-own.occam - np.log(2 * len(NAMES)), abs=1e-6)


def test_of_names_at_one_place_those_beyond_the_fourth_come_after_all_others(problem):
    order = [*(f"{name}@1" for name in NAMES), "torque_offset@2", "joint_spring@2"]
    lines = [[(9.0 - k, Line(_named(problem, x), (), {}, {}))] for k, x in enumerate(order)]
    found = [own[0][1].candidate.label for own in tables._spread(lines)]
    assert found == [*order[:4], *order[5:], order[4]]


def test_a_part_of_the_rows_ranks_as_all_of_them(problem, fitted, monkeypatch):
    candidates = [c for c in problem.names if c.entry.name in ("stribeck", "joint_spring")]
    found = []
    for kept in (1, 3):
        monkeypatch.setattr("oed.diagnosis.selection.table.BLOCK", 1)
        if kept > 1:
            columns = sum(x.shape[1] for x in found[0][0].columns)
            used = int(fitted.projection.used.sum())
            most = 4 * columns * -(-used // kept)
            monkeypatch.setattr("oed.diagnosis.selection.table.COLUMN_BYTES", most)
        table = lay_out(fitted, candidates)
        found.append((table, ranked(table, fitted, lambda _: True)))
    (whole, of_all), (part, of_part) = found
    assert len(part.rows) < 0.4 * len(whole.rows)
    (gain, best), (other, again) = of_all[0][0], of_part[0][0]
    assert best.candidate.label == again.candidate.label == "stribeck@1"
    assert gain > 100
    # A third of the rows tells it within the deviation of a third of its blocks.
    assert other == pytest.approx(gain, rel=0.2)
