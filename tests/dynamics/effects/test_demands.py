"""What physics asks of each effect: usual sizes meet it, impossible ones of the wrong sign do not."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.position import JointSpring
from oed.estimation.feasible.feasible_set import FeasibleSet, inequality_rows
from tests.dynamics.effects.arms import context_of, vertical_arm
from tests.dynamics.effects.test_catalogue import IMPOSSIBLE, USUAL

# Those of whose size or sign nothing linear can be said beforehand.
FREE = {
    "asymmetric_viscous",
    "torque_offset",
    "position_dependent_friction",
    "torque_ripple",
    "gravity_direction",
    "motor_coupling",
    "torque_gain",
    "thermal_drift",
    "encoder_eccentricity",
    "backlash",
    "joint_elasticity",
    "time_delay",
    "filter_lag",
}


def met(effect, sizes):
    return all(np.dot(d.weights, sizes) >= d.bound for d in effect.demands)


@pytest.mark.parametrize("name", sorted(USUAL))
def test_usual_sizes_meet_what_is_asked_and_impossible_ones_do_not(name):
    context = context_of(vertical_arm())
    entry = CATALOGUE[name]
    target = entry.targets(context)[-1]
    values = tuple(shape.default for shape in entry.shapes_for(context, target))
    effect = entry.build(context, target, values)
    assert met(effect, USUAL[name])
    assert bool(effect.demands) == (name not in FREE)
    if effect.demands:
        impossible = -np.abs(IMPOSSIBLE[name])
        assert not met(effect, impossible)
        assert all(d.words for d in effect.demands)


def test_a_spring_in_stretches_pulls_back_in_each():
    spring = JointSpring(0, bends=(-0.2, 0.3))
    assert met(spring, [2.0, -1.5, 1.0, 9.0])
    assert not met(spring, [2.0, -2.5, 1.0, 9.0])
    assert not met(spring, [2.0, -1.5, -1.0, 9.0])


def test_the_feasible_set_takes_them_from_the_effects():
    context = context_of(vertical_arm())
    effect = CATALOGUE["load_dependent_friction"].build(context, 1, (0.0, 1.0))
    model = dataclasses.replace(context.model, effects=(*context.model.effects, effect))
    rows = inequality_rows(FeasibleSet.of(model), model)
    own = rows.matrix[:, -1] != 0
    assert rows.matrix[own, -1].tolist() == [1.0, -1.0]
    assert rows.bound[own].tolist() == [0.0, -0.6]
    assert {"Fc_1 >= 0", "Fv_2 >= 0"} <= set(rows.names)
