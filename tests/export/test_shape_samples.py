"""Shapes are drawn as their estimates are uncertain, each on its own scale, and nothing else is."""

import numpy as np
import pytest
from scipy.stats import kstest, truncnorm

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.position import TorqueRipple
from oed.dynamics.effects.stribeck import Stribeck
from oed.dynamics.models import build_model
from oed.export.model import ShapeEstimate
from oed.export.shape_samples import draw_shapes
from oed.robot import imi_scara

COUNT = 400
LEAST_P = 1e-3  # of a distribution that is the right one


def drawn(effect, *shapes):
    model = build_model("standard", imi_scara()).with_effects(effect)
    known = (*((),) * (len(model.effects) - 1), shapes)
    return model, draw_shapes(model, known, COUNT, np.random.default_rng(1))


def shape(name, value, std):
    return ShapeEstimate(name, "1", value, std)


def test_a_speed_is_normal_on_the_scale_of_its_logarithm_and_cut_off_at_its_ends():
    _, found = drawn(Stribeck(1, 0.6), shape("speed", 0.6, 0.3))
    speeds = np.array([m.effects[-1].speed for m in found.models])
    (own,) = (s for s in CATALOGUE["stribeck"].shapes if s.name == "speed")
    ends = np.log(np.array([own.lower, own.upper]) / 0.6) / 0.5  # a half of it, one deviation
    assert kstest(np.log(speeds / 0.6) / 0.5, truncnorm(*ends).cdf).pvalue > LEAST_P
    assert own.lower <= speeds.min() < speeds.max() <= own.upper
    assert found.names == ("speed of stribeck of joint 2",)
    assert found.left == ()


def test_what_is_open_is_drawn_evenly_between_its_ends():
    _, found = drawn(Stribeck(0, 0.05, tail=0.5), shape("tail", 0.5, None))
    assert kstest([m.effects[-1].tail for m in found.models], "uniform").pvalue > LEAST_P


def test_two_shapes_of_an_effect_are_drawn_apart():
    _, found = drawn(Stribeck(0, 0.05), shape("speed", 0.05, 0.01), shape("exponent", 2.0, 0.4))
    own = np.array([(m.effects[-1].speed, m.effects[-1].exponent) for m in found.models])
    assert np.abs(np.corrcoef(np.log(own).T)[0, 1]) < 4 / np.sqrt(COUNT)
    assert (np.std(np.log(own), axis=0) > 0.1).all()


@pytest.mark.parametrize(
    ("name", "value", "std"),
    [
        ("speed", 0.05, 0.0),  # known exactly
        ("tail", 0.0, None),  # as in the plain formula
        ("curvature", 1.0, 0.1),  # no shape of this effect
    ],
)
def test_what_is_not_in_doubt_stays(name, value, std):
    model, found = drawn(Stribeck(0, 0.05), shape(name, value, std))
    assert found.names == found.left == ()
    for each in found.models:
        assert all(a is b for a, b in zip(each.effects, model.effects, strict=True))


def test_only_the_effect_in_doubt_is_another():
    model, found = drawn(Stribeck(0, 0.05), shape("speed", 0.05, 0.01))
    for each in found.models:
        assert all(a is b for a, b in zip(each.effects[:-1], model.effects[:-1], strict=True))
        assert each.effects[-1] == Stribeck(0, each.effects[-1].speed)


def test_a_shape_that_no_field_of_its_effect_holds_is_named():
    model, found = drawn(TorqueRipple(1, (6.0, 12.0)), shape("harmonic", 6.0, 0.1))
    assert found.left == ("harmonic of torque_ripple of joint 2",)
    assert found.names == ()
    assert all(each.effects[-1] is model.effects[-1] for each in found.models)
