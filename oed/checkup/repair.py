"""The suspicion that alone repairs the fit, by refits and their likelihood on what was held out.

A suspicion is named if it alone repairs the fit,

- by a likelihood that is very strong evidence over the log as it is and over every other repair:
  2 log of their ratio beyond 10 (Kass and Raftery 1995, Bayes factors, J. Am. Stat. Assoc. 90, 773-795);
- with every joint predicted again, but for those that no suspicion helps, which stay as they are, and
  are predicted better than by no torque at all;
- and with all that it needs determined by the recordings for estimation.

Where the joints hardly couple, a reversed sign leaves a fair fit. There a suspicion of signs, order or
gravity is named that more than halves the error of a joint, by the same evidence.

Signs may be reversed at several joints: they are tried one after another.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.checkup.cause import USELESS, Cause
from oed.checkup.projection import project
from oed.checkup.suspicion import Suspicion, signs, suspicions
from oed.checkup.trial import Outcome, TrialData, trial_data
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.dissipation import LEAST_SHARE
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.recording import Role
from oed.progress import told

VERY_STRONG = 10.0  # 2 log of a likelihood ratio; Kass and Raftery 1995, section 3.2
REPAIRED = 0.5  # of its error as logged, at most, that a repaired joint keeps
NO_WORSE = 1.25  # times its error as logged, of a joint that nothing helps: chance
# What turns signs; a scale or an offset is of no joint whose fit is fair.
TOLD_BY_SIGNS = ("sign", "position_sign", "order", "position_order", "gravity")


@dataclass(frozen=True)
class Tried:
    """A suspicion and what came of it."""

    suspicion: Suspicion
    outcome: Outcome


def find_repairs(
    dataset: DataSet,
    model: TorqueModel,
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
    data: TrialData,
    as_logged: Outcome,
) -> list[Tried]:
    """The suspicions that each alone repair the fit, the likeliest first."""
    tried = [
        Tried(suspicion, _laid_out(suspicion, model, recordings, data).outcome(suspicion.trial))
        for suspicion in told(tuple(suspicions(dataset)), "causes looked into")
    ]
    tried += _more_signs(dataset, data, tried)
    best_error = np.min([t.outcome.relative for t in tried], axis=0)
    helped = np.minimum(best_error, as_logged.relative) <= USELESS
    is_bad = bool((helped & (as_logged.relative > USELESS)).any())
    found = [
        t
        for t in tried
        if (
            _is_repair(t.outcome, as_logged, helped)
            if is_bad
            else t.suspicion.kind in TOLD_BY_SIGNS and halves(t.outcome, as_logged)
        )
    ]
    return sorted(found, key=lambda t: t.outcome.deviance)


def _is_repair(outcome: Outcome, as_logged: Outcome, helped: Bool[ndarray, " joints"]) -> bool:
    """Whether all joints that anything helps are predicted again, and the others stay as they are."""
    bad = helped & (as_logged.relative > USELESS)
    change = _change(outcome, as_logged)
    return bool(
        outcome.lost == 0
        and (outcome.relative[helped] <= USELESS).all()
        and (change[bad] <= REPAIRED).all()
        and ((change[~helped] > REPAIRED) & (change[~helped] <= NO_WORSE)).all()
        # A joint that no torque at all would predict better has a fault of its own.
        and (outcome.relative < 1).all()
    )


def halves(outcome: Outcome, as_logged: Outcome) -> bool:
    """Whether the error of a joint is halved at least, and none is worse."""
    change = _change(outcome, as_logged)
    return bool(outcome.lost == 0 and change.min() <= REPAIRED and change.max() <= NO_WORSE)


def _change(outcome: Outcome, as_logged: Outcome) -> Float[ndarray, " joints"]:
    before, after = as_logged.relative, outcome.relative
    return np.divide(after, before, out=np.ones_like(after), where=before > 0)


def name_repair(
    dataset: DataSet,
    model: TorqueModel,
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
    repairs: list[Tried],
    as_logged: Outcome,
) -> Cause | None:
    """The likeliest repair, if the evidence for it over all else is very strong."""
    if not repairs:
        return None
    alike = [t for t in repairs if _are_one(t.suspicion, repairs[0].suspicion)]
    # Where the sign of a torque and that of a position do the same, the torque's is named.
    near = [t for t in alike if t.outcome.deviance - repairs[0].outcome.deviance <= VERY_STRONG]
    best = next((t for t in near if t.suspicion.kind == "sign"), repairs[0])
    gain = as_logged.deviance - best.outcome.deviance
    rivals = [t for t in repairs[1:] if not _are_one(t.suspicion, repairs[0].suspicion)]
    lead = min((t.outcome.deviance for t in rivals), default=np.inf) - best.outcome.deviance
    if min(gain, lead) <= VERY_STRONG:
        return None
    suspicion = best.suspicion
    if suspicion.kind == "sign" and not _brakes(suspicion, model, recordings):
        kept = np.flatnonzero(suspicion.trial.gain > 0).tolist()
        suspicion = signs(dataset, tuple(kept))
    names = dataset.robot.joint_names
    mended = (as_logged.relative > USELESS) | (_change(best.outcome, as_logged) <= REPAIRED)
    shown = ", ".join(
        f"{names[j]} {as_logged.relative[j]:.2g} to {best.outcome.relative[j]:.2g}"
        for j in np.flatnonzero(mended)
    )
    evidence = (
        f"put right, it alone repairs what is predicted of recordings that were not fitted: relative "
        f"error of {shown}; 2 log likelihood ratio {gain:.3g}"
        + (f", {lead:.3g} to the next such cause" if np.isfinite(lead) else ", no other cause does")
    )
    return Cause(suspicion.kind, suspicion.text, suspicion.remedy, evidence)


def _are_one(one: Suspicion, other: Suspicion) -> bool:
    """Whether two cannot be told apart: with all signs, or both signs of a joint, turned they agree."""
    turned = one.trial.gain * one.turn, other.trial.gain * other.turn
    of_signs = all(x.kind in ("sign", "position_sign") for x in (one, other))
    return of_signs and bool((turned[0] == turned[1]).all() or (turned[0] == -turned[1]).all())


def _brakes(
    suspicion: Suspicion,
    model: TorqueModel,
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
) -> bool:
    """Whether with these signs friction brakes, or the torque is the file's where there is none."""
    gain = suspicion.trial.gain
    righted: dict[Role, tuple[ProcessedRecording, ...]] = {
        role: tuple(dataclasses.replace(r, tau=r.tau * gain) for r in group)
        for role, group in recordings.items()
    }
    found = project(model, righted)
    if abs(found.friction) > LEAST_SHARE:
        return found.friction > 0
    return bool(np.sum(found.correlation[found.telling]) >= 0)


def _laid_out(
    suspicion: Suspicion,
    model: TorqueModel,
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
    data: TrialData,
) -> TrialData:
    if not suspicion.changes_motion and suspicion.gravity is None:
        return data
    meant = model
    if suspicion.gravity is not None:
        meant = model.with_robot(model.robot.with_gravity(suspicion.gravity))
    return trial_data(
        recordings,
        lambda motion: meant.columns(suspicion.motion(motion)),
        remembers=meant.remembers,
    )


def _more_signs(dataset: DataSet, data: TrialData, tried: list[Tried]) -> list[Tried]:
    """Signs reversed at several joints: the best is reversed, then the next, while that tells."""
    single = [t for t in tried if t.suspicion.kind == "sign"]
    best = min(single, key=lambda t: t.outcome.deviance)
    found: list[Tried] = []
    while True:
        reversed_now = np.flatnonzero(best.suspicion.trial.gain < 0).tolist()
        more = [
            Tried(s, data.outcome(s.trial))
            for j in range(dataset.robot.n)
            if j not in reversed_now and len(reversed_now) < dataset.robot.n // 2
            for s in [signs(dataset, tuple(sorted([*reversed_now, j])))]
        ]
        following = min(more, key=lambda t: t.outcome.deviance, default=None)
        if following is None or best.outcome.deviance - following.outcome.deviance <= VERY_STRONG:
            return found
        best = following
        found.append(best)
