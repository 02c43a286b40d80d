"""One pair of rivals on one simulated arm: the truth hidden, the noise redrawn, the motion designed.

The arm of the bench hides one effect of a pair, small enough that the other is a real rival.
Noise is drawn anew end to end: every recording is made, prepared, and its noise floor read again.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from oed.diagnosis.candidates.calming import worth_beside
from oed.diagnosis.candidates.margin import decisive_between
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.candidates.telling import most_telling_first, telling
from oed.diagnosis.rivals.discrimination import NextExperiment, design_discriminating, separation
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.workbench import lay_out
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import refine
from oed.diagnosis.terms.scores import Score, scan
from oed.diagnosis.terms.trials import Trial, catalogue_trial, grid_of
from oed.diagnosis_new.noise.baseline import find_baseline
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.recording import Recording
from oed.experiment.simulation import Log
from oed.robot import Robot
from studies.bench.arm import PERIOD
from studies.bench.case import NoiseKind
from studies.bench.excitation import random_fourier_motion
from studies.bench.forms import FORMS
from studies.bench.laboratory import Laboratory, Noise, build_laboratory, expected_torque
from studies.bench.robots import ROBOTS

HORIZON = 10.0  # [s] of the motion at hand
REPETITIONS = 4
TIMID = 0.5  # of every limit that the motion at hand uses: on a poor motion more looks alike
SEEN = 20.0  # gain of a hidden effect beside the base model that a search hardly misses
SIZES = (0.003, 4.0)  # of a hidden effect, 1 is realistic
FIRST_SIZE = 0.3
TUNINGS = 3  # of the size, towards a wanted separation
CLOSE = 1.5  # ratio to the wanted separation that is close enough


@dataclass(frozen=True)
class Duel:
    """An effect that is hidden, and the one that it may be taken for.

    Attributes:
        robot: A key of the bench's arms.
        hidden: A key of the bench's forms.
        rival: Another one.
        joint: At which both act, if they act at a joint.
        noise: Of the torque signal.
        seed: Of everything random.
    """

    robot: str
    hidden: str
    rival: str
    joint: int
    noise: NoiseKind
    seed: int

    @property
    def names(self) -> tuple[str, str]:
        """What the catalogue calls the hidden effect and its rival."""
        return FORMS[self.hidden].name, FORMS[self.rival].name


@dataclass(frozen=True)
class Scene:
    """A laboratory with something hidden, and the log of the motion at hand."""

    duel: Duel
    declared: Robot
    laboratory: Laboratory
    log: Log

    def record(self, log: Log, rng: np.random.Generator, name: str) -> tuple[Recording, Recording]:
        """A recording with new noise and jitter, and the same without noise of the torque."""
        noisy, torque = self.laboratory.recording(log, rng, name=name, role="estimation")
        return noisy, dataclasses.replace(noisy, tau=torque)

    def execute(self, motion: Motion, rng: np.random.Generator) -> Log:
        """A designed motion run on the arm, as often as the one at hand."""
        return self.laboratory.log(at_control_period(motion), rng, REPETITIONS, 0.0)


@dataclass(frozen=True)
class Decision:
    """What the diagnosis makes of the hidden effect and its rival.

    Attributes:
        wrong: The rival is named.
        decided: The hidden effect leads by a decisive difference.
        misled: Its rival does.
    """

    wrong: bool
    decided: bool
    misled: bool


@dataclass(frozen=True)
class Table:
    """Recordings laid out for the diagnosis, and what they would be without torque noise."""

    shop: Workshop
    clean: tuple[Prepared, ...]

    def compare(self, duel: Duel) -> tuple[Score, Score]:
        """Hidden effect and rival, both fitted as the diagnosis fits them."""
        scores = ranked(self.shop, _pool(self.shop, duel), (), 2, thorough=True)
        return _in_order(scores, duel)

    def compare_quiet(self, duel: Duel) -> tuple[Score, Score]:
        """The same on the torque without its noise, in the units of that noise."""
        shop = self.shop
        torque = lay_out(shop.baseline, self.clean, mean=True).torque
        fit = shop.before.fit
        fit = dataclasses.replace(fit, residual=fit.projection.residual(torque))
        worth = worth_beside((), fit.rows)
        found = scan(_pool(shop, duel), fit, shop.context)
        return _in_order([refine(s, fit, shop.context, worth) for s in found], duel)

    def lead_in_fit(self, found: tuple[Score, Score]) -> float:
        """By how much the hidden effect explains more of what the arm does than its rival."""
        own, other = map(worth_beside((), self.shop.mean.rows), found)
        return own - other

    def decision(self, found: tuple[Score, Score]) -> Decision:
        """Which of them the diagnosis would name, and whether by a decisive difference."""
        own, other = found
        first = most_telling_first(self.shop, sorted(found, key=lambda s: -s.gain), ())[0]
        (said, against), unit = telling(self.shop, (), found)
        lead, margin = float(said - against), decisive_between(self.shop, own, other, unit)
        return Decision(
            wrong=first.trial.name != own.trial.name,
            decided=lead >= margin,
            misled=lead <= -margin,
        )


def set_up(duel: Duel, size: float) -> Scene:
    """The arm with its hidden effect, moved timidly; only the effect hangs on the size."""
    rng = np.random.default_rng([duel.seed, *map(ord, duel.robot + duel.hidden + duel.rival)])
    bench = ROBOTS[duel.robot]
    declared = bench.declared(Path())
    limits = declared.limits
    middle = limits.position.mean(axis=1, keepdims=True)
    timid = limits.with_(
        position=middle + TIMID * (limits.position - middle),
        velocity=TIMID * limits.velocity,
        acceleration=TIMID * limits.acceleration,
    )
    reference = random_fourier_motion(timid, HORIZON, bench.highest, PERIOD, rng)
    plain = dataclasses.replace(bench.arm(declared, rng), session=False)
    peak = np.abs(expected_torque(plain, reference[::20])).max(axis=0)
    plain = dataclasses.replace(plain, peak=tuple(peak.tolist()))
    noise = Noise.draw(duel.noise, bench.noise, rng)
    inside, outside = rng.spawn(2)
    arm = FORMS[duel.hidden].inject(plain, duel.joint, size, inside).arm
    laboratory = build_laboratory(arm, plain, noise, bench.decimation, outside)
    return Scene(duel, declared, laboratory, laboratory.log(reference, outside, REPETITIONS, 0.0))


def lay(scene: Scene, pairs: Sequence[tuple[Recording, Recording]]) -> Table:
    """Recordings, each with its noiseless twin, as the diagnosis lays them out."""
    settings = DiagnosisSettings()
    prepared, clean = (prepare(tuple(side)) for side in zip(*pairs, strict=True))
    baseline = find_baseline(TorqueModel.standard(scene.declared), prepared)
    return Table(Workshop(baseline, prepared, (), settings), clean)


def tune(duel: Duel, wanted: float, rng: np.random.Generator) -> tuple[Scene, float]:
    """A scene whose rivals are about that far apart, and its effect's size.

    An effect that nobody would notice has no rivals: it is made large enough to be seen, even
    if that sets the pair further apart.

    Args:
        duel: What to hide.
        wanted: lambda on the motion at hand.
        rng: Of the noise whose colour whitens.
    """
    size, best = FIRST_SIZE, (np.inf, set_up(duel, FIRST_SIZE), FIRST_SIZE)
    for _ in range(TUNINGS):
        scene = set_up(duel, size)
        table = lay(scene, [scene.record(scene.log, rng, "at_hand")])
        own, other = table.compare_quiet(duel)
        apart = separation(table.shop, own.trial, own.coefficients, other.trial)
        ratio = max(wanted / max(apart, 1e-3 * wanted), SEEN / max(own.gain, 1e-3 * SEEN))
        if abs(np.log(ratio)) < best[0]:
            best = (abs(np.log(ratio)), scene, size)
        if best[0] < np.log(CLOSE):
            break
        size = float(np.clip(size * np.sqrt(ratio), *SIZES))
    return best[1:]


def design(
    table: Table, found: tuple[Score, Score], rng: np.random.Generator, candidates: int
) -> NextExperiment:
    """The motion that tells the two apart; the one that fits better is the favourite."""
    better, worse = sorted(found, key=lambda s: -s.gain)
    pairs = [(better.trial, better.coefficients, worse.trial)]
    return design_discriminating(table.shop, pairs, rng, candidates=candidates)


def at_control_period(motion: Motion) -> Motion:
    """One closed period on the controller's grid."""
    step = motion.t[1] - motion.t[0]
    t = np.append(motion.t, motion.t[-1] + step) - motion.t[0]
    curve = CubicSpline(t, np.vstack([motion.q, motion.q[:1]]), bc_type="periodic")
    fine = np.arange(round(t[-1] / PERIOD)) * PERIOD
    return Motion(fine, curve(fine), curve(fine, 1), curve(fine, 2))


def _pool(shop: Workshop, duel: Duel) -> list[Trial]:
    """Both candidates over the grids of their shapes."""
    trials = []
    for key in (duel.hidden, duel.rival):
        entry = CATALOGUE[FORMS[key].name]
        target = None if FORMS[key].whole_arm else duel.joint
        trials += [
            catalogue_trial(entry, shop.context, target, values, shop.mean.rows)
            for values in grid_of(entry.shapes_for(shop.context, target))
        ]
    return trials


def _in_order(scores: Sequence[Score], duel: Duel) -> tuple[Score, Score]:
    by_name = {s.trial.name: s for s in scores}
    return by_name[duel.names[0]], by_name[duel.names[1]]
