"""The catalogue: 21 names, each a term of the same torque model on any arm."""

import dataclasses
import time
from itertools import product

import casadi
import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.context import Context
from oed.dynamics.effects.effect import State
from oed.dynamics.effects.entries.payload import FOR_GOOD
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.motion import with_joint
from oed.dynamics.torque_model import TorqueModel
from tests.dynamics.effects.arms import context_of, panda, scara, smooth_motion, vertical_arm

NAMES = [
    "stribeck",
    "nonlinear_viscous",
    "asymmetric_viscous",
    "torque_offset",
    "presliding_hysteresis",
    "backlash",
    "load_dependent_friction",
    "position_dependent_friction",
    "torque_ripple",
    "joint_spring",
    "gravity_direction",
    "rotor_inertia",
    "motor_coupling",
    "torque_gain",
    "torque_saturation",
    "time_delay",
    "filter_lag",
    "joint_elasticity",
    "thermal_drift",
    "payload_change",
    "encoder_eccentricity",
]
KINDS = ("q", "dq", "ddq")
WITH_HISTORY = {
    "presliding_hysteresis",
    "backlash",
    "time_delay",
    "filter_lag",
    "joint_elasticity",
}
# Sizes at which each effect is well within what was ever reported.
USUAL = {
    "stribeck": [0.5],
    "nonlinear_viscous": [0.2],
    "asymmetric_viscous": [-0.2],
    "torque_offset": [-0.5],
    "presliding_hysteresis": [1.5],
    "backlash": [1.0],
    "load_dependent_friction": [0.06],
    "position_dependent_friction": [0.3, -0.2],
    "torque_ripple": [0.2, -0.1],
    "joint_spring": [1.0, -0.3],
    "gravity_direction": [0.02, -0.03],
    "rotor_inertia": [0.1],
    "motor_coupling": [0.05, 0.1, 0.2],
    "torque_gain": [-0.08],
    "torque_saturation": [0.05],
    "time_delay": [1.0],
    "filter_lag": [1.0],
    "joint_elasticity": [1.0],
    "thermal_drift": [0.2, 0.3],
    "encoder_eccentricity": [3e-4, -4e-4],
}
# Sizes that no joint has, or of the wrong sign.
IMPOSSIBLE = {
    "stribeck": [-0.5],
    "nonlinear_viscous": [1e4],
    "asymmetric_viscous": [8.0],
    "torque_offset": [1e4],
    "presliding_hysteresis": [-1.0],
    "backlash": [-1.0],
    "load_dependent_friction": [-0.1],
    "position_dependent_friction": [30.0, 0.0],
    "torque_ripple": [0.0, 30.0],
    "joint_spring": [-5.0, 0.0],
    "gravity_direction": [3.0, 3.0],
    "rotor_inertia": [-0.1],
    "motor_coupling": [np.nan, 0.0, 0.0],
    "torque_gain": [0.9],
    "torque_saturation": [1e4],
    "time_delay": [-1.0],
    "filter_lag": [9.0],
    "joint_elasticity": [-0.5],
    "thermal_drift": [-5.0, -5.0],
    "encoder_eccentricity": [0.3, 0.0],
}


@pytest.fixture(scope="module")
def contexts() -> dict[str, Context]:
    return {"scara": context_of(scara()), "vertical": context_of(vertical_arm())}


@pytest.fixture(scope="module")
def arm() -> Context:
    robot = panda()
    return context_of(robot, smooth_motion(robot, step=0.05))


def _defaults(name: str, context: Context, target) -> tuple[float, ...]:
    return tuple(shape.default for shape in CATALOGUE[name].shapes_for(context, target))


@pytest.mark.parametrize("name", NAMES)
def test_trial_values_are_within_the_narrowed_ranges(
    name: str, contexts: dict[str, Context]
) -> None:
    entry, context = CATALOGUE[name], contexts["scara"]
    target = entry.targets(context)[0]
    shapes = entry.shapes_for(context, target)
    trials = list(product(*(shape.grid for shape in shapes)))
    assert (
        len(set(trials))
        == len(trials)
        == np.prod([s.points + len(s.also) for s in shapes], dtype=int)
    )
    for values in trials:
        for shape, value in zip(shapes, values, strict=True):
            rounding = 1e-9 * abs(value)
            inside = shape.lower - rounding <= value <= shape.upper + rounding
            assert inside or shape.is_idle(value)


def test_names_are_those_of_the_interface() -> None:
    assert list(CATALOGUE) == [entry.name for entry in CATALOGUE.values()]
    assert sorted(CATALOGUE) == sorted(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_page_says_everything(name: str) -> None:
    entry = CATALOGUE[name]
    for field in dataclasses.fields(entry.page):
        assert getattr(entry.page, field.name), field.name
    assert set(entry.page.confused_with) <= set(NAMES) - {name}
    assert any(year in entry.page.source for year in ("19", "20"))
    for shape in entry.shapes:
        assert len(shape.grid) == shape.points + len(shape.also)
        ends = (shape.lower, shape.upper) if shape.points > 1 else (shape.default, shape.default)
        assert (shape.grid[0], shape.grid[shape.points - 1]) == pytest.approx(ends)


@pytest.mark.parametrize("name", NAMES)
def test_builds_and_evaluates_for_every_target(name: str, contexts: dict[str, Context]) -> None:
    for context in contexts.values():
        motion = smooth_motion(context.model.robot)
        entry = CATALOGUE[name]
        for target in entry.targets(context):
            effect = entry.build(context, target, _defaults(name, context, target))
            columns = evaluate(effect, motion, context.n)
            assert columns.shape == (len(motion), context.n, len(effect.parameters))
            assert np.isfinite(columns).all()
            assert all(parameter.unit for parameter in effect.parameters)
            joint_of_target = target[0] if isinstance(target, tuple) else target
            if entry.scope == "joint":
                assert {parameter.joint for parameter in effect.parameters} == {joint_of_target}


@pytest.mark.parametrize("name", NAMES)
def test_a_coordinate_that_an_effect_does_not_name_does_not_change_it(
    name: str, contexts: dict[str, Context]
) -> None:
    context, entry = contexts["vertical"], CATALOGUE[name]
    motion = smooth_motion(context.model.robot, 1.0)
    for target in entry.targets(context):
        effect = entry.build(context, target, _defaults(name, context, target))
        columns = evaluate(effect, motion, context.n)
        for joint, kind in product(range(context.n), KINDS):
            there = [getattr(motion, x)[:, joint] + 0.3 * (x == kind) for x in KINDS]
            if not effect.changes_along(f"{kind}_{joint + 1}"):
                moved = evaluate(effect, with_joint(motion, joint, there), context.n)
                np.testing.assert_array_equal(moved, columns)


@pytest.mark.parametrize("name", NAMES)
def test_the_augmented_model_is_an_ordinary_torque_model(
    name: str, contexts: dict[str, Context]
) -> None:
    context = contexts["vertical"]
    entry = CATALOGUE[name]
    motion = smooth_motion(context.model.robot)
    target = entry.targets(context)[-1]
    values = _defaults(name, context, target)
    effect = entry.build(context, target, values)
    estimates = np.full(len(effect.parameters), 0.01)
    model = entry.apply(context, target, values, estimates)
    names = [parameter.name for parameter in model.parameters]
    assert len(set(names)) == len(names)
    added = len(names) - len(context.model.parameters)
    assert added == (0 if entry.install else len(effect.parameters))
    regressor = model.regressor(motion)
    assert regressor.shape == (len(motion) * context.n, len(names))
    changed = len(names) != len(context.model.parameters) or not np.allclose(
        regressor, context.model.regressor(motion), rtol=0, atol=1e-12
    )
    assert changed


@pytest.mark.parametrize("name", sorted(USUAL))
def test_usual_sizes_are_plausible_and_impossible_ones_are_not(
    name: str, contexts: dict[str, Context]
) -> None:
    context = contexts["vertical"]
    entry = CATALOGUE[name]
    target = entry.targets(context)[0]
    values = _defaults(name, context, target)
    assert entry.plausible(context, target, values, np.array(USUAL[name])) is None
    reason = entry.plausible(context, target, values, np.array(IMPOSSIBLE[name]))
    assert isinstance(reason, str)


def test_a_load_of_ten_arms_is_not_plausible(contexts: dict[str, Context]) -> None:
    context = contexts["vertical"]
    entry = CATALOGUE["payload_change"]
    count = len(entry.build(context, None, (3.0, 0.0, FOR_GOOD)).parameters)
    assert entry.plausible(context, None, (3.0, 0.0, FOR_GOOD), np.full(count, 1.0)) is None
    reason = entry.plausible(context, None, (3.0, 0.0, FOR_GOOD), np.full(count, 1e4))
    assert reason is not None
    assert "mass" in reason


@pytest.mark.parametrize("name", sorted(set(NAMES) - WITH_HISTORY))
def test_symbols_and_numbers_give_the_same_columns(name: str, contexts: dict[str, Context]) -> None:
    context = contexts["vertical"]
    entry = CATALOGUE[name]
    motion = smooth_motion(context.model.robot, step=1.0)
    target = entry.targets(context)[-1]
    effect = entry.build(context, target, _defaults(name, context, target))
    model = TorqueModel(context.model.robot, (effect,))
    q, dq, ddq = (casadi.SX.sym(x, context.n) for x in ("q", "dq", "ddq"))
    symbolic = casadi.Function(
        "columns", [q, dq, ddq], [model.symbolic_columns(q, dq, ddq, sign_width=0.0)]
    )
    # A symbolic state has no time: it stands at the start of the session.
    numeric = [model.columns(motion[k : k + 1])[0] for k in range(len(motion))]
    for k, expected in enumerate(numeric):
        found = np.asarray(symbolic(motion.q[k], motion.dq[k], motion.ddq[k]))
        assert found == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("name", sorted(WITH_HISTORY))
def test_effects_with_history_refuse_symbols_clearly(
    name: str, contexts: dict[str, Context]
) -> None:
    context = contexts["vertical"]
    entry = CATALOGUE[name]
    target = entry.targets(context)[0]
    effect = entry.build(context, target, _defaults(name, context, target))
    parts = [casadi.vertsplit(casadi.SX.sym(x, context.n)) for x in ("q", "dq", "ddq")]
    with pytest.raises(ValueError, match=f"{name} depends on the history"):
        effect.entries(State(0.0, *parts, sign_width=0.1))


@pytest.mark.parametrize("name", NAMES)
def test_every_entry_builds_and_evaluates_on_a_seven_joint_arm(name: str, arm: Context) -> None:
    motion = smooth_motion(arm.model.robot, step=0.05)
    entry = CATALOGUE[name]
    target = entry.targets(arm)[-1]
    effect = entry.build(arm, target, _defaults(name, arm, target))
    columns = evaluate(effect, motion, arm.n)
    assert np.isfinite(columns).all()
    assert np.abs(columns).max() > 0


def test_every_entry_evaluates_fast() -> None:
    context = context_of(vertical_arm())
    motion = smooth_motion(context.model.robot, duration=12.0, step=1e-3)
    seconds = {}
    for name, entry in CATALOGUE.items():
        target = entry.targets(context)[-1]
        effect = entry.build(context, target, _defaults(name, context, target))
        evaluate(effect, motion[:50], context.n)  # compiles what is compiled
        start = time.perf_counter()
        evaluate(effect, motion, context.n)
        seconds[name] = time.perf_counter() - start
    assert max(seconds.values()) < 2.0, seconds  # generous: the machine may be shared
