"""How often a search looks ahead, and which of several candidates it takes."""

import dataclasses

import pytest

from oed.diagnosis.evidence.views import Views
from oed.diagnosis.numbers import LOOKS
from oed.diagnosis.selection import look_ahead, search
from oed.diagnosis.selection.screen import evaluate
from oed.diagnosis.selection.tables import Tables, as_term
from oed.diagnosis.setup import pose
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set, stribeck


@pytest.fixture(scope="module")
def start():
    dataset = data_set(23, repetitions=1, extra=stribeck(1.5))
    names = ("torque_offset", "joint_spring")
    problem = pose(dataset, TorqueModel.standard(dataset.robot), names=names)[0]
    return Views.of(problem, (), "fitted")


def _scored(start, label):
    candidate = next(c for c in start.problem.names if c.label == label)
    tried = (evaluate(candidate, v, start.means) for v in candidate.grid(start.problem.context))
    return next(s for s in tried if s is not None)


def test_it_looks_once_more_without_what_was_dropped_and_no_further(start, monkeypatch):
    """Whatever is added is dropped again, each time something else."""
    labels = ["torque_offset@1", "joint_spring@1", "torque_offset@2"]
    refused = []

    def grown(tables, views, say, over, without):
        refused.append(without)
        return views.grown((as_term(_scored(start, labels[len(refused) - 1])),), "fitted")

    monkeypatch.setattr(search, "look_ahead", grown)
    monkeypatch.setattr(search, "prune", lambda views, say: views.grown((), "all"))
    tables = Tables.of(start, start.problem.names)
    found = search._ahead_and_back(tables, start, lambda _: None, lambda: False)
    assert found.terms == ()
    assert refused == [frozenset(labels[:k]) for k in range(LOOKS)]


def test_of_what_predicts_better_the_one_that_is_worth_most_is_added(start, monkeypatch):
    worth = {"torque_offset@1": 3.0, "joint_spring@1": 7.0, "torque_offset@2": 5.0}
    monkeypatch.setattr(
        look_ahead, "_worth_when_refitted", lambda scored, *_: worth[scored.candidate.label]
    )
    tried = [_scored(start, label) for label in worth]
    tried = [dataclasses.replace(s, worth=dataclasses.replace(s.worth, nats=1.0)) for s in tried]
    options, grown = look_ahead._options(start, tried)
    assert [own for own, _ in options] == [7.0, 5.0, 3.0]
    assert grown is not None
    assert [t.label for t in grown.terms] == ["joint_spring@1"]
