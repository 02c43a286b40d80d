"""What repetitions of one motion differ by: noise, and whatever keeps its own time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.evidence.final_model import FinalModel
from oed.diagnosis_new.noise.baseline import Baseline
from oed.experiment.preparation.prepared import Prepared

PADDING = 2  # ratio of a transform's to its signal's length: a line may lie between two frequencies
# [rad/s] Least velocity with a direction, of a joint that no encoder sees move.
AT_REST = 1e-9


@dataclass(frozen=True)
class Differing:
    """What the repetitions of one recording differ by, and where the arm was.

    Attributes:
        torque: (N, n) less its mean at each phase, zero where it is uncertain [N m]; of a motion
            that is not repeated, all that the model leaves.
        position: (N, n) [rad or m].
        direction: (N, n) of motion, in -1 to 1.
        period: Of the motion [samples]; infinite for one that is not repeated.
        predicted: (N, n) what the motion makes expect, for one that is not repeated [N m].
    """

    torque: Float[ndarray, "samples joints"]
    position: Float[ndarray, "samples joints"]
    direction: Float[ndarray, "samples joints"]
    period: float
    predicted: Float[ndarray, "samples joints"] | None = None


def differing(
    model: FinalModel, estimation: Sequence[Prepared], baseline: Baseline
) -> tuple[Differing, ...]:
    """Of every repeated recording, what a fitted model leaves of it.

    Args:
        model: Takes off what the motion's own differences between repetitions explain.
        estimation: Recordings, repeated or not.
        baseline: Knows which rows are uncertain.
    """
    repeated = tuple(p for p in estimation if p.period is not None)
    found = []
    for p, weights in zip(repeated, baseline.certainty(repeated), strict=True):
        error = p.fine_torque - model.model.torque(model.parameters, p.motion)
        between = p.band.apply(error - p.phase_mean(error))
        period = (p.period or 0.0) * p.band.analysis_rate
        found.append(Differing(_certain(between, p, weights), *_state(p), period))
    return tuple(found)


def left_of_single(
    model: FinalModel, recordings: Sequence[Prepared], baseline: Baseline
) -> tuple[Differing, ...]:
    """What a fitted model leaves of every recording that is not repeated.

    Args:
        model: Takes off what the motion explains.
        recordings: Repeated or not.
        baseline: Knows which rows are uncertain.
    """
    single = tuple(p for p in recordings if p.period is None)
    found = []
    for p, weights in zip(single, baseline.certainty(single), strict=True):
        predicted = p.band.apply(model.model.torque(model.parameters, p.motion))
        torque = _certain(p.torque - predicted, p, weights)
        found.append(Differing(torque, *_state(p), np.inf, predicted))
    return tuple(found)


def _certain(
    torque: Float[ndarray, "samples joints"],
    prepared: Prepared,
    weights: Float[ndarray, "valid joints"],
) -> Float[ndarray, "samples joints"]:
    """A torque by how certain each row is, zero where there is none."""
    found = np.zeros_like(torque)
    found[prepared.valid] = weights * torque[prepared.valid]
    return found


def _state(
    prepared: Prepared,
) -> tuple[Float[ndarray, "samples joints"], Float[ndarray, "samples joints"]]:
    """Position and direction of motion in the analysis band."""
    motion, band = prepared.motion, prepared.band
    return band.apply(motion.q), band.apply(
        np.tanh(motion.dq / np.maximum(prepared.sign_noise, AT_REST))
    )
