"""A gear is judged on the torque that it leaves, not on that of an arm taken for rigid."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.candidates import ranking
from oed.diagnosis.candidates.open_shapes import decided
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.candidates.ripening import has_crests, ripened
from oed.diagnosis.candidates.telling import most_telling_first
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.sharpening import sharpened
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import at_rest, refine
from oed.diagnosis.terms.scores import scan, score
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.baseline import find_baseline
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepare import prepare
from oed.experiment.recording import Recording
from oed.robot import imi_scara
from tests.diagnosis.shop import trial_of
from tests.dynamics.effects.arms import smooth_motion
from tests.dynamics.effects.two_mass import Gear, two_mass_torque

SPRING = Gear(frequency=6.0, damping=0.08, rotor=0.15)
COULOMB, VISCOUS, NOISE = np.array([2.6, 1.5]), np.array([7.3, 0.8]), np.array([0.1, 0.02])
WIDTH = 0.01  # [rad/s]
BEARING = 0.6  # share of the friction that sits behind the loose gear
PLAY = Gear(
    frequency=20.0,
    damping=0.6,
    rotor=0.3,
    gap=1.5e-3,
    coulomb=BEARING * COULOMB[1],
    width=WIDTH,
    viscous=BEARING * VISCOUS[1],
)
BEHIND = Gear(
    frequency=6.0,
    damping=0.08,
    rotor=0.15,
    coulomb=BEARING * COULOMB[1],
    width=WIDTH,
    viscous=BEARING * VISCOUS[1],
)
GEARS = ("backlash", "joint_elasticity")
RIVALS = ("backlash", "presliding_hysteresis", "load_dependent_friction")
PACE = 5.0  # times as fast: a spring shows in what accelerates


def _shop(joint: int, gear: Gear, *, unseen: bool = False) -> Workshop:
    """A workshop of an arm with that gear at a joint; with a slower validation motion if `unseen`."""
    rng = np.random.default_rng(3)
    recordings = [_record(rng, joint, gear, PACE, 80.0 if unseen else 20.0)]
    if unseen:
        slower = _record(rng, joint, gear, 0.8 * PACE, duration=80.0)
        recordings.append(dataclasses.replace(slower, name="validation", role="validation"))
    settings = DiagnosisSettings()
    prepared, *others = prepare(tuple(recordings))
    baseline = find_baseline(TorqueModel.standard(imi_scara()), (prepared,))
    return Workshop(baseline, (prepared,), tuple(others), settings)


def _record(
    rng: np.random.Generator, joint: int, gear: Gear, pace: float, duration: float = 20.0
) -> Recording:
    robot = imi_scara()
    slow = smooth_motion(robot, duration=duration, step=5e-3)
    motion = Motion(slow.t / pace, slow.q, pace * slow.dq, pace**2 * slow.ddq)
    friction = COULOMB * np.tanh(motion.dq / WIDTH) + VISCOUS * motion.dq
    torque = two_mass_torque(robot, motion, joint, gear)
    for j in range(2):
        behind = BEARING if j == joint and gear.coulomb > 0 else 0.0
        torque[:, j] += (1 - behind) * friction[:, j]
    torque = torque + NOISE * rng.normal(size=torque.shape)
    measured = motion.q + 1e-6 * rng.normal(size=motion.q.shape)
    return Recording("estimation", "estimation", motion.t, measured, torque)


def test_finds_the_spring_that_the_wrong_torque_hides():
    shop = _shop(0, SPRING)
    fit = shop.fit(()).fit
    trials = [t for t in shop.physical if t.key == ("joint_elasticity", 0)]
    unripe = refine(scan(trials, fit, shop.context)[0], fit, shop.context)
    scores = [score(t, fit) for t in trials]
    ripe = ripened(shop, scores, (), fit)
    assert ripe.gain > unripe.gain
    frequency, damping, rotor_share, bearing, stiffening = ripe.trial.values
    assert frequency == pytest.approx(SPRING.frequency, rel=0.03)
    assert damping == pytest.approx(SPRING.damping, rel=0.2)
    assert rotor_share == pytest.approx(SPRING.rotor, abs=0.05)
    assert bearing == pytest.approx(0.0, abs=0.05)
    assert stiffening == pytest.approx(0.0, abs=0.1)
    # What the arm taken for rigid makes of the rotor is far off.
    assert abs(unripe.trial.values[2] - SPRING.rotor) > 3 * abs(rotor_share - SPRING.rotor)


def test_a_spring_is_found_with_the_friction_behind_it():
    shop = _shop(1, BEHIND)
    pool = [t for t in shop.physical if t.name in GEARS and t.target == 1]
    found = {s.trial.name: s for s in ranked(shop, pool, (), 3, thorough=True)}
    spring, rows = found["joint_elasticity"], shop.full.rows.count
    assert spring.evidence(rows) > found["backlash"].evidence(rows)
    frequency, _, _, bearing, _ = spring.trial.values
    assert frequency == pytest.approx(BEHIND.frequency, rel=0.03)
    # It trades places with the rotor's share along a valley in which a simplex stops.
    assert bearing == pytest.approx(BEARING, abs=0.25)


def test_a_gap_is_found_with_all_its_shapes():
    shop = _shop(1, PLAY)
    first = _leading_rival(shop)
    assert first.key == ("backlash", 1)
    # Without the gap, blows had passed for a sign of the other joint that turns slowly.
    sharper = sharpened(shop, [first])
    assert sharper is not None
    gap, _, _, rotor_share, bearing = _leading_rival(sharper).values
    assert gap == pytest.approx(PLAY.gap, rel=0.15)
    assert rotor_share == pytest.approx(PLAY.rotor, abs=0.1)
    assert bearing == pytest.approx(BEARING, abs=0.05)


def test_what_one_motion_leaves_open_of_a_gap_is_decided_by_another():
    """Where friction sits trades places with all other shapes along a valley of little fall."""
    shop = _shop(1, PLAY, unseen=True)
    aside = trial_of(shop, "backlash", 1, (2e-3, 40.0, 0.6, 0.4, 0.9))
    begun = score(aside, shop.before.fit)
    found = decided(shop, (), begun)

    def foretold(trial):
        errors = shop.validation_rms(shop.fit([trial], bend=False), as_it_is=True)
        return errors / shop.baseline.floor.deviation

    assert found.trial.decided
    assert foretold(found.trial)[1] < 0.6 * foretold(begun.trial)[1]
    gap, frequency, _, _, bearing = found.trial.values
    assert gap == pytest.approx(PLAY.gap, rel=0.15)
    assert frequency == pytest.approx(PLAY.frequency, rel=0.2)
    assert bearing == pytest.approx(BEARING, abs=0.1)


def _leading_rival(shop: Workshop) -> Trial:
    """The candidate that explains most of what the loose gear does."""
    pool = [t for t in shop.physical if t.name in RIVALS and t.target == 1]
    return max(ranked(shop, pool, (), 3, thorough=True), key=lambda s: s.gain).trial


@pytest.mark.parametrize(("name", "is_wide"), [("backlash", True), ("joint_elasticity", False)])
def test_a_gap_alone_is_searched_for_over_its_whole_range(name, is_wide):
    """A spring has as many shapes, but all that a simplex finds."""
    shop = _shop(0, SPRING)
    assert has_crests(score(trial_of(shop, name, 0), shop.before.fit)) is is_wide


def test_a_gap_that_promises_most_is_searched_even_where_a_simplex_finds_nothing(monkeypatch):
    def lost(shop, scores, others, fit):
        return min(scores, key=lambda s: s.gain)

    monkeypatch.setattr(ranking, "ripened", lost)
    shop = _shop(1, PLAY)
    pool = [t for t in shop.physical if t.name in RIVALS and t.target == 1]
    found = {s.trial.key: s for s in ranked(shop, pool, (), 3, thorough=True)}
    fit = shop.fit((), bend=False).fit
    # As good a place as the one above the truth: a gap trades places with the damping of its flanks.
    shapes = (PLAY.gap, PLAY.frequency, PLAY.damping, PLAY.rotor, BEARING)
    truth = at_rest(score(trial_of(shop, "backlash", 1, shapes), fit), fit, shop.context)
    assert found["backlash", 1].gain > truth.gain - 1.0


def test_a_spring_explains_what_a_gap_with_the_same_spring_does(monkeypatch):
    """By its own grid the spring may stop on a lesser crest, and a gap be named that adds nothing."""
    own = ranking.ripened

    def lost(shop, scores, others, fit):
        if scores[0].trial.name == "joint_elasticity":
            return min(scores, key=lambda s: s.gain)
        return own(shop, scores, others, fit)

    monkeypatch.setattr(ranking, "ripened", lost)
    shop = _shop(0, SPRING)
    pool = [t for t in shop.physical if t.name in GEARS and t.target == 0]
    found = {s.trial.name: s for s in ranked(shop, pool, (), 3, thorough=True)}
    spring, gap = (found[name] for name in ("joint_elasticity", "backlash"))
    assert spring.gain > 0.95 * gap.gain > 0
    # What a gap adds besides is of no weight: the plainer of the two is meant.
    first, *_ = most_telling_first(shop, sorted((spring, gap), key=lambda s: -s.gain), ())
    assert first.trial.name == "joint_elasticity"


def test_a_lag_is_evaluated_on_what_a_gear_does_and_a_gear_on_the_rigid_arm():
    shop = _shop(0, SPRING)
    gear = trial_of(shop, "joint_elasticity", 0, (6.0, 0.08, 0.15, 0.0, 0.0))
    plain = trial_of(shop, "filter_lag", None, (0.01, 0.0))
    shop.update_context(shop.fit([gear], bend=False))
    (motion,) = (p.motion for p in shop.mean.rows.prepared)
    bent = shop.context.reference.parts(motion).sum(axis=2)
    rigid = shop.context.unyielding.parts(motion).sum(axis=2)
    change = evaluate(gear.effect, motion, 2)[:, :, 0]
    assert np.abs(change).max() > 0.05 * np.abs(rigid).max()
    assert bent - rigid == pytest.approx(change, abs=1e-9 * np.abs(rigid).max())
    # What is recorded late is the torque that the gear shows, by the filter's own equation.
    late = evaluate(shop.renewed(plain).effect, motion, 2)[:, :, 0] + bent
    rate = np.gradient(late, motion.t, axis=0)
    settled = motion.t > motion.t[0] + 0.2
    left = (late + 0.01 * rate - bent)[settled]
    # Differences of steps of 1 ms, friction's leaps smoothed, err by far less than the gear does.
    assert np.sqrt(np.mean(left**2)) < 0.1 * np.sqrt(np.mean(change[settled] ** 2))
