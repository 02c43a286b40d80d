"""What may be named: a formula that the data drive to the end of its range is none."""

import pytest

from oed.diagnosis.evidence.term import Term
from oed.diagnosis.evidence.views import Views
from oed.diagnosis.inference.answer import is_driven_out
from oed.diagnosis.selection.judge import judge, prune
from oed.diagnosis.selection.screen import evaluate, polish
from oed.diagnosis.selection.tables import as_term
from oed.diagnosis.setup import pose
from oed.dynamics.effects.entry import Shape
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set, stribeck


def _start(extra):
    """The base model of a data set with more torque, and a candidate that could be it."""
    dataset = data_set(5, extra=extra)
    problem = pose(dataset, TorqueModel.standard(dataset.robot), names=("stribeck",))[0]
    candidate = next(c for c in problem.names if c.label == "stribeck@1")
    return Views.of(problem, (), "all"), candidate


@pytest.mark.parametrize(("speed", "is_driven"), [(0.1, False), (0.8, False), (1.6, True)])
def test_a_shape_that_is_driven_past_what_is_plausible_is_no_name(speed, is_driven):
    start, candidate = _start(stribeck(3.0, speed=speed))
    problem = start.problem
    tried = (evaluate(candidate, v, start.means) for v in candidate.grid(problem.context))
    best = polish(max((s for s in tried if s is not None), key=lambda s: s.nats), start.means)
    assert is_driven_out(start.grown((as_term(best),), "all"), 0) is is_driven


@pytest.mark.parametrize(("size", "is_plausible"), [(3.0, True), (9.0, False)])
def test_what_ends_outside_its_priors_support_is_worth_nothing(size, is_plausible):
    # Whatever it was when it was added. At standstill friction is no more than 2.5 times Coulomb's above that.
    start, candidate = _start(stribeck(size))
    whole = start.grown((Term(candidate, (0.1, 2.0, 1.0)),), "all")
    assert whole.told.size(0) == pytest.approx([size], abs=0.3)
    assert (judge(whole, 0).worth.nats > 0) is is_plausible
    assert bool(prune(whole, print).terms) is is_plausible


def test_a_range_is_left_only_where_a_value_can_be_that_is_not_plausible():
    speed = Shape("speed", "rad/s", 0.01, 1.0, "log", 5, 0.1)
    assert speed.past(1.0) == (1.0, 1.25)
    assert speed.outside(1.25) == pytest.approx(1.0 * 100**0.25)
    assert speed.past(0.01) == (-0.25, 0.0)
    assert speed.past(0.5) is None
    gap = Shape("gap", "rad", 1e-4, 1e-2, "log", 5, 1e-3, open_below=True)
    assert gap.past(1e-4) is None
    assert gap.past(1e-2) == (1.0, 1.25)
    assert Shape("share", "1", 0.0, 1.0, "linear", 3, 0.0).past(1.0) is None
    harmonic = Shape("harmonic", "1/turn", 2.0, 330.0, "linear", 500, 6.0, is_bounded=True)
    assert harmonic.past(2.0) is not None
    plain = Shape("tail", "1", 0.0, 1.0, "signed log", 3, 0.0, linear_below=0.1, plain=True)
    assert plain.past(0.0) is None
