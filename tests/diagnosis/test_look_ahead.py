"""What may be added: only what the rows that are held out can judge, and do."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.diagnose import diagnose
from oed.diagnosis.evidence.columns import white_effect
from oed.diagnosis.evidence.moments import moments_of
from oed.diagnosis.evidence.views import Views
from oed.diagnosis.selection.look_ahead import is_tested
from oed.diagnosis.selection.screen import (
    evaluate,
    least_price,
    most_gained,
    polish,
    promised,
    weighed,
)
from oed.diagnosis.selection.search import as_handed_on, keep_predictive
from oed.diagnosis.selection.sign_refit import with_refitted_sign
from oed.diagnosis.selection.tables import as_term
from oed.diagnosis.setup import pose
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import signs_of, with_signs
from tests.diagnosis.arm import INERTIA, data_set, stribeck


def _bent(q, dq, ddq):
    """A bent curve over the first position, and the fall of friction from standstill."""
    result = stribeck(1.5)(q, dq, ddq)
    result[:, 0] += 4.0 * np.sin(4 * q[:, 0])
    return result


@pytest.fixture(scope="module")
def problem():
    dataset = data_set(23, repetitions=1, extra=_bent)
    found, _, _ = pose(dataset, TorqueModel.standard(dataset.robot), names=("stribeck",))
    return found


def _over_position(problem, held_out):
    """A model with a curve over the first position, and other rows held out."""
    rows = dataclasses.replace(problem.rows, held_out=held_out)
    there = dataclasses.replace(problem, rows=rows)
    views = Views.of(there, (), "fitted")
    curve = next(c for c in problem.smooth if c.label == "f(q_1)[11]@1")
    scored = evaluate(curve, (), views.means)
    assert scored is not None
    return views.grown((as_term(scored),), "fitted")


def test_a_curve_is_judged_where_held_out_rows_visit_it_and_not_from_a_corner(problem):
    validation = problem.rows.held_out
    q = np.concatenate([p.band.apply(p.motion.q[:, :1])[:, 0] for p in problem.rows.prepared])
    assert is_tested(_over_position(problem, validation))
    corner = validation & (q > np.quantile(q[validation], 0.9))
    assert not is_tested(_over_position(problem, corner))


def _with_stribeck(problem, held_out):
    rows = dataclasses.replace(problem.rows, held_out=held_out)
    there = dataclasses.replace(problem, rows=rows)
    views = Views.of(there, (), "fitted")
    law = next(c for c in problem.names if c.label == "stribeck@1")
    tried = (evaluate(law, shapes, views.means) for shapes in law.grid(problem.context))
    return views.grown((as_term(next(s for s in tried if s is not None)),), "fitted")


def test_a_formula_is_tested_by_any_rows_that_have_some_of_it_and_by_no_others(problem):
    validation = problem.rows.held_out
    grown = _with_stribeck(problem, validation)
    own = grown.means.projection.columns[0, :, grown.means.places[-1]][:, 0]
    few = np.flatnonzero(validation)[np.argsort(-np.abs(own[validation]))[:20]]
    there = np.zeros_like(validation)
    there[few] = True
    assert is_tested(_with_stribeck(problem, there))
    nothing = validation & (np.abs(own) < 1e-3 * np.abs(own).max())
    assert nothing.sum() > 20
    assert not is_tested(_with_stribeck(problem, nothing))


def test_a_curve_is_not_judged_by_rows_along_the_path_that_was_fitted():
    """Validation that plays an estimation motion again sees every knot, and tests none."""
    dataset = data_set(24, repetitions=1, extra=_bent, roles=("estimation", "estimation", "test"))
    first, second, test = dataset.recordings
    for motion, tested in ((first, False), (test, True)):
        again = dataclasses.replace(motion, name="again", role="validation")
        replayed = dataclasses.replace(dataset, recordings=(first, second, again))
        model = TorqueModel.standard(dataset.robot)
        posed, _, _ = pose(replayed, model, names=("stribeck",))
        assert is_tested(_over_position(posed, posed.rows.held_out)) is tested


def test_each_joints_rows_weigh_by_what_is_left_of_them(problem):
    """One joint with errors of 36 deviations bends what another is fitted with only until it weighs less."""
    fitted = Views.of(problem, (), "fitted").means
    left = fitted.squares(fitted.projection.used) / fitted.rows(fitted.projection.used)
    assert left[0] > 1000 * left[1]
    assert fitted.variance == pytest.approx(np.maximum(left, fitted.tolerated), rel=0.02)


def test_columns_that_are_nothing_tell_nothing(problem):
    views = Views.of(problem, (), "all")
    fitted = views.every
    told = moments_of(fitted, fitted.projection, {}, fitted.projection.used)
    assert told.information == pytest.approx(0)
    assert told.score == pytest.approx(0)


def test_no_candidate_gains_more_than_its_bound(problem):
    """What the bound refuses to weigh could not have been worth its price."""
    fitted = Views.of(problem, (), "fitted").means
    counted = fitted.rows(fitted.projection.used)
    weighed_ones = 0
    for candidate in problem.candidates[:40]:
        for values in list(candidate.grid(problem.context))[:3]:
            scored = evaluate(candidate, values, fitted)
            if scored is None:
                continue
            effect = candidate.effect(fitted.context, values)
            beside = fitted.projection.beside(white_effect(effect, fitted.installed, problem.rows))
            own = weighed(candidate, values, fitted, beside, counted)
            weighed_ones += 1
            assert own is not None
            assert own.nats <= most_gained(beside, counted) - least_price(candidate, problem) + 1e-6
    assert weighed_ones > 30


def test_a_sign_that_is_too_wide_is_made_sharp_beside_all_terms(problem):
    wide = {j: dataclasses.replace(sign, width=1.0) for j, sign in signs_of(problem.base).items()}
    blunt = dataclasses.replace(problem, base=with_signs(problem.base, wide))
    views = Views.of(blunt, (), "fitted")
    refitted = with_refitted_sign(views, "fitted")
    for joint, sign in signs_of(refitted.problem.base).items():
        assert sign.width < 0.1 * wide[joint].width
    assert refitted.rise(views, "fitted") > 100
    # Of joints that nothing was asked of, signs stay as they are.
    only = with_refitted_sign(views, "fitted", {0})
    assert signs_of(only.problem.base)[1] == wide[1]
    assert signs_of(only.problem.base)[0].width < 0.1


def test_nuisances_that_take_up_what_the_model_explains_have_no_part_in_the_estimate(problem):
    friction = Views.of(problem.bare, (), "fitted").every.projection.columns[:, :, -1:]
    rng = np.random.default_rng(3)
    noise = 1e-3 * rng.normal(size=friction.shape)
    idle = Views.of(dataclasses.replace(problem, nuisances=noise), (), "all")
    assert as_handed_on(idle, lambda _: None).problem.nuisances is noise
    greedy = Views.of(dataclasses.replace(problem, nuisances=friction + noise), (), "all")
    estimated = as_handed_on(greedy, lambda _: None).every.parameters
    alone = as_handed_on(Views.of(problem.bare, (), "all"), lambda _: None).every.parameters
    assert estimated == pytest.approx(alone, rel=1e-3)  # weights of rows settle to a per cent
    assert greedy.every.parameters != pytest.approx(alone, rel=1e-2)


def test_a_term_has_to_serve_where_it_is_handed_on_without_nuisances(problem, monkeypatch):
    friction = Views.of(problem.bare, (), "fitted").every.projection.columns[:, :, -1:]
    noise = 1e-3 * np.random.default_rng(3).normal(size=friction.shape)
    law = next(c for c in problem.names if c.label == "stribeck@1")
    fitted = Views.of(problem.bare, (), "fitted").means
    tried = (evaluate(law, shapes, fitted) for shapes in law.grid(problem.context))
    term = as_term(next(s for s in tried if s is not None))
    # Beside nuisances it gains, without it does not.
    monkeypatch.setattr(
        "oed.diagnosis.selection.search._gains_ahead",
        lambda views: [10.0 if views.problem.nuisances.size else -1.0] * len(views.terms),
    )

    def kept(nuisances):
        there = dataclasses.replace(problem, nuisances=nuisances)
        return keep_predictive(Views.of(there, (term,), "all"), lambda _: None).terms

    assert kept(noise)
    assert not kept(friction + noise)


def test_a_drift_is_compared_on_the_rows_that_show_it():
    """Friction that falls while the arm warms up; repetitions of a mean do not show that."""

    def warming(t, dq):
        cold = np.exp(-(t - t[0]) / 12.0)[:, None]
        return cold * np.array([1.5, 0.0]) * np.sign(dq)

    dataset = data_set(31, repetitions=3, hum=warming)
    problem, _, _ = pose(dataset, TorqueModel.standard(dataset.robot), names=("thermal_drift",))
    start = Views.of(problem, (), "fitted")
    law = next(c for c in problem.names if c.label == "thermal_drift@1")
    tried = [evaluate(law, shapes, start.every) for shapes in law.grid(problem.context)]
    best = max((s for s in tried if s is not None), key=lambda s: s.nats)
    grown = start.grown((as_term(best),), "fitted")
    assert grown.rise(start, "fitted") > 100
    assert grown.rise(start, "held_out") > 50
    assert start.rise(grown, "held_out") == pytest.approx(-grown.rise(start, "held_out"))


@pytest.fixture(scope="module")
def late():
    """A delay, and the fit without it to a torque that is 4 ms late."""
    dataset = data_set(36, repetitions=1, late=0.004)
    problem, _, _ = pose(dataset, TorqueModel.standard(dataset.robot), names=("time_delay",))
    law = next(c for c in problem.names if c.label == "time_delay")
    return law, Views.of(problem, (), "fitted").showing(law)


def test_a_delay_that_is_far_too_long_on_the_grid_leads_to_the_right_one(late):
    """At thrice the delay the torque fits worse than at none, and its direction is right."""
    law, fitted = late
    scored = evaluate(law, (0.012,), fitted)
    assert scored is not None
    assert scored.nats < -100
    counted = fitted.rows(fitted.projection.used)

    def beside(values):
        effect = law.effect(fitted.context, values)
        columns = white_effect(effect, fitted.installed, fitted.problem.rows)
        return fitted.projection.beside(columns)

    promise = promised(law, scored.values, fitted, beside(scored.values), counted)
    assert promise is not None
    assert promise.nats > 100
    assert polish(scored, fitted).nats > 0
    # The other way it would have to be less than nothing.
    other = evaluate(law, (-0.012,), fitted)
    assert other is not None
    promise = promised(law, other.values, fitted, beside(other.values), counted)
    assert promise is not None
    assert promise.nats == pytest.approx(other.nats)


def test_shapes_are_fitted_beyond_the_next_of_the_grid(late):
    """From 0.3 ms the right delay is several steps of the grid away."""
    law, fitted = late
    scored = evaluate(law, (0.0003,), fitted)
    assert scored is not None
    assert polish(scored, fitted).values[0] == pytest.approx(0.004, rel=0.1)


def test_a_strong_spring_is_held_to_what_it_alone_gives():
    """Most of a spring's torque could be gravity's: only the rest can be its formula's fault."""

    def spring_and_gravity(q, *_):
        _, x, y, _ = INERTIA
        second = 9.81 * (x * np.cos(q.sum(axis=1)) - y * np.sin(q.sum(axis=1)))
        return np.stack([12.0 * np.cos(q[:, 0]) + second + 60.0 * q[:, 0], second], axis=1)

    level = data_set(52, extra=spring_and_gravity, repetitions=1)
    upright = level.robot.with_gravity(np.array([0.0, -9.81, 0.0]))
    names = ("stribeck", "torque_offset", "joint_spring", "rotor_inertia", "nonlinear_viscous")
    dataset = dataclasses.replace(level, robot=upright)
    found = diagnose(dataset, TorqueModel.standard(upright), names=names)
    (effect,) = found.effects
    assert (effect.name, effect.joint, found.unexplained) == ("joint_spring", 0, ())
    stiffness = effect.parameters[0]
    assert stiffness.std is not None
    assert abs(stiffness.value - 60.0) < 4 * stiffness.std
