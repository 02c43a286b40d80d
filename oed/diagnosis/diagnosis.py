"""The whole diagnosis of a data set: residual, search, verdict, proof."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from threadpoolctl import threadpool_limits

from oed.diagnosis.candidates.accepted import Refused
from oed.diagnosis.evidence.caveats import caveats
from oed.diagnosis.evidence.contradiction import checked_errors
from oed.diagnosis.evidence.contributions import Contribution, contributions
from oed.diagnosis.evidence.dependence import Dependence, Spectrum, dependences, spectrum
from oed.diagnosis.evidence.estimates import Estimated
from oed.diagnosis.evidence.final_model import FinalModel, errors_of
from oed.diagnosis.evidence.lack_of_fit import LackOfFit, lack_of_fit
from oed.diagnosis.evidence.own_time import in_own_time
from oed.diagnosis.evidence.proof import RoleProof, prove
from oed.diagnosis.evidence.taken_up import with_moments_of
from oed.diagnosis.evidence.unlocated import expected_unseen, shown_by_test, unlocated
from oed.diagnosis.evidence.verdict import (
    FoundEffect,
    Outcome,
    Unexplained,
    decide,
    describe_unexplained,
    riddles,
)
from oed.diagnosis.evidence.withheld import Errors, withheld
from oed.diagnosis.finding import Finding, find, uncontradicted
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.predict import rms
from oed.diagnosis.tables.sharpening import sharpened
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.baseline import Baseline, find_baseline
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects.catalogue import Drives
from oed.dynamics.effects.entries.measurement import standing
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.dissipation import check_dissipation, driven_joints
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.encoder_steps import encoder_torque
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.recording import ROLES


@dataclass(frozen=True)
class Diagnosis:
    """What a base model lacks on a data set.

    Attributes:
        verdict: In the interface's words.
        effects: What was found and named.
        unexplained: What is there and has no name.
        standing: All that is part of the augmented model, with and without a name.
        before: The base model, fitted.
        after: The augmented model, fitted: an ordinary torque model.
        proof: Errors before and after, one entry a role that has recordings.
        unchecked: (n,) test error of all that was found, before the test recordings took something
            back [N m]; None where they took nothing.
        noise_floor: (n,) deviation of noise in the band, steps of encoders included [N m].
        noise_source: Where that was read off.
        expected: (n,) error on the validation recordings, in noise floors, that noise and the
            parameters that it leaves uncertain let expect; one without such recordings.
        lack_before: Of the base model.
        lack_after: Of the augmented model.
        dependences: Residual of the base model over every coordinate.
        dependences_after: Residual of the augmented model.
        contributions: What each addition does.
        spectrum: Of both residuals.
        refused: Candidates that were turned down, and why.
        moments: When a load comes in recordings that have a moment of their own.
        cutoff: Of the analysis band [Hz].
        sign_width: (n,) velocity below which the direction is uncertain [rad/s].
        shop: The laid-out data, for whoever designs the next experiment.
        notes: What the base model says of the data that cannot be right.
    """

    verdict: Outcome
    effects: tuple[FoundEffect, ...]
    unexplained: tuple[Unexplained, ...]
    standing: tuple[Trial, ...]
    before: FinalModel
    after: FinalModel
    proof: tuple[RoleProof, ...]
    unchecked: Float[ndarray, " joints"] | None
    noise_floor: Float[ndarray, " joints"]
    noise_source: str
    expected: Float[ndarray, " joints"]
    lack_before: LackOfFit
    lack_after: LackOfFit
    dependences: tuple[Dependence, ...]
    dependences_after: tuple[Dependence, ...]
    contributions: tuple[Contribution, ...]
    spectrum: Spectrum
    refused: tuple[Refused, ...]
    moments: Mapping[str, Estimated]
    cutoff: float
    sign_width: Float[ndarray, " joints"]
    shop: Workshop = field(repr=False, compare=False)
    notes: tuple[str, ...] = ()

    def rival_pairs(self) -> list[tuple[Trial, Float[ndarray, " columns"], Trial]]:
        """Found effects, their coefficients, and the rivals that the data cannot exclude."""
        if not self.effects:
            return []
        found = self.shop.fit(self.standing)
        keys = [trial.key for trial in self.standing]
        return [
            (effect.trial, found.coefficients[keys.index(effect.trial.key)], rival.trial)
            for effect in self.effects
            for rival in effect.rivals
            if rival.contender
        ]


# Thousands of small matrices: more threads of BLAS wait for one another, and take twice as long.
@threadpool_limits.wrap(limits=1)
def diagnose(
    dataset: DataSet,
    model: TorqueModel,
    settings: DiagnosisSettings,
    say: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Find what a torque model lacks, from a data set alone.

    Args:
        dataset: Recordings with roles; "test" is looked at last: to report, and to
            take back names that it contradicts.
        model: The base model.
        settings: How to look.
        say: Receives lines of progress.

    Raises:
        ValueError: If there is no estimation recording, or one is too short.
        OedError: If a joint stands still, or friction drives every joint, as with torques of the
            opposite sign.
    """
    if not dataset.estimation:
        raise ValueError(
            f"data set {dataset.name!r} has no recording with role estimation: give that role to one in "
            "its dataset.toml"
        )
    dataset.check_moves()
    prepared = prepare(dataset.recordings)
    by_role = {role: tuple(p for p in prepared if p.role == role) for role in ROLES}
    estimation = by_role["estimation"]
    say(f"analysis band up to {prepared[0].band.cutoff:.3g} Hz")
    baseline = find_baseline(standing(model), estimation)
    deviations = zip(baseline.floor.deviation, model.robot.joints, strict=True)
    levels = ", ".join(f"{level:.3g} {joint.unit('N m')}" for level, joint in deviations)
    say(f"noise, as first read off {baseline.floor.source}: {levels}")
    drives = _drives(dataset)
    held = by_role["validation"]
    later = held or by_role["test"]
    shop = Workshop(baseline, estimation, held, settings, drives=drives, later=later)
    notes = _sign_notes(shop, dataset.name)
    _say_all(notes, say)
    # The mean over repetitions, which a search looks at, shows a sign's turn better than they do.
    shop = sharpened(shop, ()) or shop
    found = find(shop, held)
    result = uncontradicted(found, held, by_role["test"])
    added, refused = len(result.selection.accepted), len(result.selection.refused)
    say(f"additions, with and without a name: {added}; refused: {refused}")
    unchecked = None if result is found else _unchecked(found, by_role["test"])
    diagnosis = _conclude(result, by_role, settings, unchecked)
    doubts = caveats(diagnosis.effects, diagnosis.proof, model.robot)
    _say_all(doubts, say)
    return dataclasses.replace(diagnosis, notes=(*notes, *doubts))


def _say_all(notes: Sequence[str], say: Callable[[str], None]) -> None:
    for note in notes:
        say(f"note: {note}")


def _drives(dataset: DataSet) -> Drives:
    ratio = dataset.drive.gear_ratio
    gears = None if ratio is None else tuple(float(x) for x in ratio)
    return Drives(gears, of_motors=dataset.torque != "measured")


def _sign_notes(shop: Workshop, name: str) -> tuple[str, ...]:
    """What friction says of the torques' signs, joint by joint; refused where all are wrong."""
    fit, prepared = shop.before.fit, shop.estimation
    names = (p.name for p in fit.model.parameters)
    friction = dict(zip(names, fit.full_parameters().tolist(), strict=True))
    dq = np.concatenate([p.band.apply(p.motion.dq) for p in prepared])
    torque = np.concatenate([p.torque for p in prepared])
    check_dissipation(friction, dq, torque, name)
    joints = fit.model.robot.joint_names
    return tuple(
        f"{joints[j]}: in the base model friction drives it instead of braking it "
        f"(Fc_{j + 1} = {friction.get(f'Fc_{j + 1}', 0.0):.3g}): is the sign of tau_{j + 1} opposite to that of "
        f"q_{j + 1}, or the order of the columns another?"
        for j in driven_joints(friction, dq, torque)
    )


def _conclude(
    result: Finding,
    by_role: dict[str, tuple[Prepared, ...]],
    settings: DiagnosisSettings,
    unchecked: Float[ndarray, " joints"] | None,
) -> Diagnosis:
    shop, selection, effects = result.shop, result.selection, result.effects
    before = result.before
    after, moments = with_moments_of(shop, selection.found, result.after, by_role["test"])
    baseline, estimation = shop.baseline, by_role["estimation"]
    unexplained = describe_unexplained(shop, selection)
    # A change in time that is not met in full passes for one that goes on.
    changing = {j for a in selection.accepted if a.trial.between_repetitions for j in a.trial.group}
    unexplained += tuple(
        u for u in in_own_time(after, by_role, baseline) if u.joint not in changing
    )
    floor = _with_rounding(baseline, before, shop.layout_for(selection.trials).rows)
    left = lack_of_fit(after.fit, baseline.floor.freedom)
    old, new = errors_of(before, estimation), errors_of(after, estimation)
    proof = _proof(before, after, by_role, baseline, settings)
    errors = Errors.of(proof, floor)
    riddling = riddles(effects, unexplained)
    unexplained += tuple(unlocated(shop, selection.trials, riddling, left, errors))
    effects, unexplained = withheld(shop, selection, effects, unexplained, errors)
    unexplained += tuple(
        shown_by_test(shop, selection.trials, unexplained, errors, by_role["test"])
    )
    return Diagnosis(
        verdict=decide(effects, unexplained),
        effects=effects,
        unexplained=unexplained,
        standing=selection.trials,
        before=before,
        after=after,
        proof=proof,
        unchecked=unchecked,
        noise_floor=floor,
        noise_source=baseline.floor.source,
        expected=expected_unseen(shop, selection.trials),
        lack_before=lack_of_fit(before.fit, baseline.floor.freedom),
        lack_after=left,
        dependences=dependences(estimation, old),
        dependences_after=dependences(estimation, new),
        contributions=contributions(shop, selection, after, floor),
        spectrum=spectrum(old, new, estimation[0].band.analysis_rate),
        refused=selection.refused,
        moments=moments,
        cutoff=estimation[0].band.cutoff,
        sign_width=estimation[0].sign_noise,
        shop=shop,
    )


def _unchecked(found: Finding, test: tuple[Prepared, ...]) -> Float[ndarray, " joints"]:
    _, errors = checked_errors(found.shop, found.selection, found.before, found.after, test)
    return errors * found.shop.baseline.floor.deviation


def _with_rounding(baseline: Baseline, before: FinalModel, rows: Rows) -> Float[ndarray, " joints"]:
    """(n,) the noise floor with what encoder steps err [N m]."""
    errors = encoder_torque(partial(before.model.torque, before.parameters), rows.prepared)
    valid = [e[p.valid] for e, p in zip(errors, rows.prepared, strict=True)]
    return np.hypot(baseline.floor.deviation, rms(valid, baseline.noise_share(rows.prepared)))


def _proof(
    before: FinalModel,
    after: FinalModel,
    by_role: dict[str, tuple[Prepared, ...]],
    baseline: Baseline,
    settings: DiagnosisSettings,
) -> tuple[RoleProof, ...]:
    rng = np.random.default_rng(settings.seed)
    return tuple(
        prove(
            role,
            errors_of(before, prepared),
            errors_of(after, prepared),
            [p.torque[p.valid] for p in prepared],
            baseline.noise_share(prepared),
            rate=prepared[0].band.analysis_rate,
            replicates=settings.bootstrap,
            rng=rng,
        )
        for role, prepared in by_role.items()
        if prepared
    )
