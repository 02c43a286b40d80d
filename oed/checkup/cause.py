"""The one thing that is wrong with a log, if a test shows it; otherwise none.

Two kinds of test decide. What leaves the fit as it is (all signs, one unit, a gear left out everywhere)
is told by the file's own inertials (`projection`). All else is told by refits: a suspicion is named
if it alone repairs the fit of what was held out,

- by a likelihood that is very strong evidence over the log as it is and over every other repair:
  2 log of their ratio beyond 10 (Kass and Raftery 1995, Bayes factors, J. Am. Stat. Assoc. 90, 773-795);
- with every joint foretold again, but for those that no suspicion helps, which may not get worse;
- and with all that it needs determined by the recordings for estimation.

Signs may be reversed at several joints: they are tried one after another.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool
from numpy import ndarray

from oed.checkup.projection import Projection, project
from oed.checkup.suspicion import UNITS, Suspicion, signs, suspicions
from oed.checkup.trial import Outcome, Trial, TrialData, trial_data
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.dissipation import LEAST_SHARE
from oed.experiment.dataset import DataSet
from oed.experiment.processing import ProcessedRecording
from oed.experiment.recording import Role

USELESS = 0.3  # rms residual over rms torque; measured arms reach a few per cent, wrists ten or so
VERY_STRONG = 10.0  # 2 log of a likelihood ratio; Kass and Raftery 1995, section 3.2
REPAIRED = 0.5  # of its error as logged, at most, that a repaired joint keeps
NO_WORSE = 1.1  # times its error as logged, of a joint that nothing helps
# Inertials of robot files, and even placeholders, give a joint's torque to its order of magnitude.
MAGNITUDE = np.sqrt(10.0)
NEAR_ZERO = 0.02  # of a joint's largest torque
OTHER_UNIT = 10.0  # farther from 1 than any such file


@dataclass(frozen=True)
class Cause:
    """What is wrong with a log.

    Attributes:
        kind: "sign", "position_sign", "order", "position_order", "gravity", "scale", "gear",
            "offset" or "magnitude".
        text: In words, a sentence without its full stop.
        remedy: What to do about it.
        evidence: What shows it, in words.
    """

    kind: str
    text: str
    remedy: str
    evidence: str


@dataclass(frozen=True)
class Search:
    """What the tests say of a data set.

    Attributes:
        cause: The one cause; None where no test shows one.
        projection: On the file's own inertials.
        as_logged: Held-out error of the log as it is, with what its own fit reaches.
    """

    cause: Cause | None
    projection: Projection
    as_logged: Outcome


def find_cause(
    dataset: DataSet,
    model: TorqueModel,
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
) -> Search:
    """Test a data set for what may be wrong with it.

    Args:
        dataset: As read.
        model: Of its robot, without measurement effects.
        recordings: By role, processed; a thinned rate will do.
    """
    projection = project(model, recordings)
    data = trial_data(recordings, model.columns)
    as_logged = data.outcome(Trial.unchanged(dataset.robot.n))
    repairs: list[_Tried] = []
    cause = None
    if (as_logged.relative > USELESS).any():
        cause = _magnitude(dataset)
        if cause is None:
            repairs = _repairs(dataset, model, recordings, data, as_logged)
            cause = _named(dataset, model, recordings, repairs, as_logged)
    # Of repairs that nothing tells apart none is named, and the file's inertials are no judge of them.
    if cause is None and not repairs:
        cause = _all_reversed(dataset, projection) or _all_scaled(dataset, projection)
    return Search(cause, projection, as_logged)


def _all_reversed(dataset: DataSet, projection: Projection) -> Cause | None:
    """Every joint that tells has the file's torque with the opposite sign, and friction drives."""
    telling = np.flatnonzero(projection.telling)
    if not len(telling) or (projection.correlation[telling] > 0).any():
        return None
    drives = projection.friction < -LEAST_SHARE
    if not (drives or (projection.friction < LEAST_SHARE and len(telling) > 1)):
        return None
    names = dataset.robot.joint_names
    shown = ", ".join(f"{projection.correlation[j]:.2f} at {names[j]}" for j in telling)
    evidence = f"correlation with the torque of the robot file's own inertials {shown}"
    if drives:
        evidence += "; friction would drive the joints instead of braking them"
    every = f"tau_1 ... tau_{len(names)}" if len(names) > 1 else "tau_1"
    return Cause("sign", "all torques have the opposite sign", f"reverse {every}", evidence)


def _all_scaled(dataset: DataSet, projection: Projection) -> Cause | None:
    """Every joint that tells has the file's torque divided by its gear ratio, or by one factor."""
    telling = projection.telling & (projection.slope > 0)
    ratios = dataset.drive.gear_ratio
    if ratios is not None:
        geared = np.flatnonzero(telling & (np.abs(ratios) > 1))
        slope = projection.slope[geared]
        if len(geared) and _all_of_size(slope * np.abs(ratios[geared])) and _is_other(slope):
            return _gear_left_out(dataset, projection, geared)
    joints = np.flatnonzero(telling)
    slope = projection.slope[joints]
    if len(joints) < 2 or not _is_other(slope):
        return None
    for factor, words in UNITS.items():
        if _all_of_size(slope / factor):
            text = f"the torques are in {words}"
            return Cause(
                "scale", text, f"divide them by {factor:g}", _slopes(dataset, slope, joints)
            )
    middle = float(np.exp(np.mean(np.log(slope))))
    # Inertials that are too small by as much are placeholders; too large ones are not made up.
    if middle > 1 or not _all_of_size(slope / middle):
        return None
    text = f"the torques are {middle:.2g} of what the robot file's inertials need: a gear or a unit"
    remedy = (
        "convert them to N m at the joint; current_to_torque holds the gear ratio: N m at the joint "
        "per A of the motor"
    )
    return Cause("scale", text, remedy, _slopes(dataset, slope, joints))


def _gear_left_out(dataset: DataSet, projection: Projection, joints: ndarray) -> Cause:
    ratios = np.abs(np.asarray(dataset.drive.gear_ratio))
    shown = ", ".join(
        f"{dataset.robot.joint_names[j]} {projection.slope[j]:.3g} (1/{ratios[j]:g} is {1 / ratios[j]:.3g})"
        for j in joints
    )
    has_constant = dataset.drive.current_to_torque is not None
    remedy = (
        "multiply current_to_torque in [drive] by gear_ratio: it is N m at the joint per A of the motor"
        if has_constant
        else "multiply the tau columns by the gear ratios: they are torques at the joint"
    )
    return Cause(
        "gear",
        "the torques are those of the motors: the gear ratio is left out",
        remedy,
        f"measured torque over that of the robot file's own inertials: {shown}",
    )


def _slopes(dataset: DataSet, slope: ndarray, joints: ndarray) -> str:
    names = dataset.robot.joint_names
    shown = ", ".join(f"{names[j]} {x:.3g}" for j, x in zip(joints, slope, strict=True))
    return f"measured torque over that of the robot file's own inertials: {shown}"


def _all_of_size(ratio: ndarray) -> bool:
    return bool(np.all((ratio > 1 / MAGNITUDE) & (ratio < MAGNITUDE)))


def _is_other(slope: ndarray) -> bool:
    return bool(np.all(slope < 1 / OTHER_UNIT) or np.all(slope > OTHER_UNIT))


def _magnitude(dataset: DataSet) -> Cause | None:
    """No torque is ever negative though every joint turns both ways, and none pulls one way alone."""
    tau = np.concatenate([recording.tau for recording in dataset.recordings])
    lowest, size = tau.min(axis=0), np.abs(tau).max(axis=0)
    # A weight that is held one way only keeps its torque away from zero.
    touches = lowest < NEAR_ZERO * size
    if dataset.robot.n < 2 or not np.all((lowest >= 0) & touches & (size > 0)):
        return None
    return Cause(
        "magnitude",
        "the torques are magnitudes: their signs are lost",
        "log the torques with their signs",
        "no joint has a negative torque in any recording, though each comes near zero",
    )


@dataclass(frozen=True)
class _Tried:
    suspicion: Suspicion
    outcome: Outcome


def _repairs(
    dataset: DataSet,
    model: TorqueModel,
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
    data: TrialData,
    as_logged: Outcome,
) -> list[_Tried]:
    """The suspicions that each alone repair the fit, the likeliest first."""
    tried = [
        _Tried(suspicion, _laid_out(suspicion, model, recordings, data).outcome(suspicion.trial))
        for suspicion in suspicions(dataset)
    ]
    tried += _more_signs(dataset, data, tried)
    best_error = np.min([t.outcome.relative for t in tried], axis=0)
    helped = np.minimum(best_error, as_logged.relative) <= USELESS
    found = [t for t in tried if _is_repair(t.outcome, as_logged, helped)]
    return sorted(found, key=lambda t: t.outcome.deviance)


def _is_repair(outcome: Outcome, as_logged: Outcome, helped: Bool[ndarray, " joints"]) -> bool:
    bad = helped & (as_logged.relative > USELESS)
    return bool(
        outcome.lost == 0
        and bad.any()
        and (outcome.relative[helped] <= USELESS).all()
        and (outcome.relative[~helped] <= NO_WORSE * as_logged.relative[~helped]).all()
        and (outcome.relative[bad] <= REPAIRED * as_logged.relative[bad]).all()
    )


def _named(
    dataset: DataSet,
    model: TorqueModel,
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
    repairs: list[_Tried],
    as_logged: Outcome,
) -> Cause | None:
    """The likeliest repair, if the evidence for it over all else is very strong."""
    if not repairs:
        return None
    best = repairs[0]
    gain = as_logged.deviance - best.outcome.deviance
    rivals = [t for t in repairs[1:] if not _are_mirrored(t.suspicion, best.suspicion)]
    lead = min((t.outcome.deviance for t in rivals), default=np.inf) - best.outcome.deviance
    if min(gain, lead) <= VERY_STRONG:
        return None
    suspicion = best.suspicion
    if suspicion.kind == "sign" and not _brakes(suspicion, model, recordings):
        kept = np.flatnonzero(suspicion.trial.gain > 0).tolist()
        suspicion = signs(dataset, tuple(kept))
    names = dataset.robot.joint_names
    shown = ", ".join(
        f"{names[j]} {as_logged.relative[j]:.2g} to {best.outcome.relative[j]:.2g}"
        for j in np.flatnonzero(as_logged.relative > USELESS)
    )
    evidence = (
        f"put right, it alone repairs what is foretold of recordings that were not fitted: relative "
        f"error of {shown}; 2 log likelihood ratio {gain:.3g}"
        + (f", {lead:.3g} to the next such cause" if np.isfinite(lead) else ", no other cause does")
    )
    return Cause(suspicion.kind, suspicion.text, suspicion.remedy, evidence)


def _are_mirrored(one: Suspicion, other: Suspicion) -> bool:
    """Whether two reverse complementary joints: with all signs turned they are the same."""
    return one.kind == other.kind == "sign" and (one.trial.gain == -other.trial.gain).all().item()


def _brakes(
    suspicion: Suspicion,
    model: TorqueModel,
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
) -> bool:
    """Whether with these signs friction brakes, or the torque is the file's where there is none."""
    gain = suspicion.trial.gain
    righted = {
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
    return trial_data(recordings, lambda motion: meant.columns(suspicion.motion(motion)))


def _more_signs(dataset: DataSet, data: TrialData, tried: list[_Tried]) -> list[_Tried]:
    """Signs reversed at several joints: the best is reversed, then the next, while that tells."""
    single = [t for t in tried if t.suspicion.kind == "sign"]
    best = min(single, key=lambda t: t.outcome.deviance)
    found: list[_Tried] = []
    while True:
        reversed_now = np.flatnonzero(best.suspicion.trial.gain < 0).tolist()
        more = [
            _Tried(s, data.outcome(s.trial))
            for j in range(dataset.robot.n)
            if j not in reversed_now and len(reversed_now) < dataset.robot.n // 2
            for s in [signs(dataset, tuple(sorted([*reversed_now, j])))]
        ]
        following = min(more, key=lambda t: t.outcome.deviance, default=None)
        if following is None or best.outcome.deviance - following.outcome.deviance <= VERY_STRONG:
            return found
        best = following
        found.append(best)
