"""What is asked in a term's place: a curve within noise of a formula is none of its rivals."""

import dataclasses
from itertools import combinations

import numpy as np
import pytest

from oed.diagnosis.evidence.views import Views
from oed.diagnosis.selection import substitutes
from oed.diagnosis.selection.judge import judge
from oed.diagnosis.selection.screen import evaluate
from oed.diagnosis.selection.substitutes import in_place, substitutes_of
from oed.diagnosis.selection.tables import Tables, as_term
from oed.diagnosis.setup import pose
from oed.dynamics.effects.coordinates import Coordinate
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set


def _spring(bend):
    """A weak spring at the first joint, of which a part is bent by no formula that is tried."""

    def torque(q, dq, ddq):
        result = np.zeros_like(q)
        result[:, 0] = 0.2 * q[:, 0] + bend * np.sin(4 * q[:, 0])
        return result

    return torque


def _asked(bend, label):
    """What could stand in the place of a term, and the term's own label."""
    dataset = data_set(61, repetitions=1, extra=_spring(bend))
    problem = pose(dataset, TorqueModel.standard(dataset.robot), names=("joint_spring",))[0]
    start = Views.of(problem, (), "all")
    candidate = next(c for c in problem.candidates if c.label == label)
    scored = evaluate(candidate, next(iter(candidate.grid(problem.context))), start.means)
    assert scored is not None
    whole = start.grown((as_term(scored),), "all")
    tables = Tables.of(Views.of(problem, (), "fitted"), problem.candidates)
    return substitutes_of(tables, whole, judge(whole, 0))


@pytest.mark.parametrize(("bend", "is_same"), [(0.0, True), (0.3, False)])
def test_a_curve_gives_a_formulas_torque_where_noise_alone_parts_them(bend, is_same):
    curve = next(s for s in _asked(bend, "joint_spring@1") if s.term.label.startswith("f(q_1)["))
    assert curve.is_same is is_same


def test_a_curve_is_not_weighed_against_itself():
    labels = [s.term.label for s in _asked(0.3, "f(q_1)[11]@1")]
    assert labels.count("f(q_1)[11]@1") == 1


def test_what_is_worth_nothing_stands_in_no_ones_place(monkeypatch):
    """At so large a dilution neither the curve nor the drift is worth anything: that is no gain."""
    dataset = data_set(61, repetitions=2, extra=_spring(0.3))
    problem = pose(dataset, TorqueModel.standard(dataset.robot), names=("thermal_drift",))[0]
    start = Views.of(problem, (), "all")

    def term(label):
        candidate = next(c for c in problem.candidates if c.label == label)
        fitted = start.showing(candidate)
        tried = (evaluate(candidate, v, fitted) for v in candidate.grid(problem.context))
        return as_term(next(s for s in tried if s is not None))

    whole = start.grown((term("f(q_1)[11]@1"),), "all")
    own = judge(whole, 0)
    drift = in_place(whole, own, term("thermal_drift@1"))
    nats = {"f(q_1)[11]@1": -15.0, "thermal_drift@1": -7.0}
    monkeypatch.setattr(
        substitutes,
        "worth_of",
        lambda views, k, _: dataclasses.replace(own.worth, nats=nats[views.terms[k].label]),
    )
    assert substitutes._nats_in_place(drift, whole, own) == -7.0
    nats["thermal_drift@1"] = 7.0
    assert substitutes._nats_in_place(drift, whole, own) == pytest.approx(own.worth.nats + 22.0)


def test_curves_reach_as_far_as_all_that_is_fitted():
    dataset = data_set(62, repetitions=1, near=0.5)
    problem = pose(dataset, TorqueModel.standard(dataset.robot), names=("joint_spring",))[0]
    curve = next(c for c in problem.smooth if c.label == "f(q_1)[11]@1").term.coordinates[0]
    q = np.concatenate([p.motion.q[:, 0] for p in problem.rows.prepared if p.role == "validation"])
    assert curve.lower == pytest.approx(q.min(), abs=0.05)
    assert curve.upper == pytest.approx(q.max(), abs=0.05)


def test_a_small_arm_has_curves_over_any_two_of_its_coordinates():
    dataset = data_set(62, repetitions=1, near=0.5)
    problem = pose(dataset, TorqueModel.standard(dataset.robot), names=("joint_spring",))[0]
    states = ("q_1", "dq_1", "q_2", "dq_2")
    for joint in range(2):
        found = {
            frozenset(f"{c.kind}_{c.joint + 1}" for c in own.term.coordinates)
            for own in problem.smooth
            if own.joint == joint
            and len(own.term.coordinates) == 2
            and all(isinstance(c, Coordinate) for c in own.term.coordinates)
        }
        assert {frozenset(pair) for pair in combinations(states, 2)} <= found


def test_an_effect_is_weighed_against_its_equal_at_another_joint():
    """Torque of joint 2 read 7 % too large is torque of joint 1 read too small, beside other masses."""
    dataset = data_set(62, repetitions=1)
    grown = tuple(
        dataclasses.replace(r, tau=r.tau * np.array([1.0, 1.07])) for r in dataset.recordings
    )
    dataset = dataclasses.replace(dataset, recordings=grown)
    problem = pose(dataset, TorqueModel.standard(dataset.robot), names=("torque_gain",))[0]
    start = Views.of(problem, (), "all")
    candidate = next(c for c in problem.candidates if c.label == "torque_gain@2")
    scored = evaluate(candidate, next(iter(candidate.grid(problem.context))), start.means)
    assert scored is not None
    whole = start.grown((as_term(scored),), "all")
    tables = Tables.of(Views.of(problem, (), "fitted"), problem.candidates)
    mine, other = (
        next(s for s in substitutes_of(tables, whole, judge(whole, 0)) if s.term.label == label)
        for label in ("torque_gain@2", "torque_gain@1")
    )
    assert other.is_same
    assert other.nats == pytest.approx(mine.nats, abs=1.0)
