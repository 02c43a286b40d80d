"""What a found model asks of a motion: its effects as columns, its covariance as what is known already.

Under J_d every parameter counts by how much the motion would narrow it, so that what a model leaves in
doubt is what the motion excites.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.known_arm import NOISE, KnownTorqueModel, drive_sizes
from oed.design.problem import DesignProblem
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.effects import Effect, with_columns
from oed.dynamics.online import Offline
from oed.dynamics.torque_model import TorqueModel

RANK = 1e-10  # of the largest variance, in units of the deviations: beneath it nothing was sampled


def not_designed_for(model: TorqueModel) -> tuple[Offline, ...]:
    """What of a model no motion can be designed for, and why."""
    effects = [(effect.name, _reason(effect)) for effect in model.effects]
    seen = "it changes whole signals after the arm's torque, and adds no column"
    return (
        *(Offline(name, reason) for name, reason in effects if reason),
        *(Offline(effect.name, seen) for effect in model.measurement),
    )


def _reason(effect: Effect) -> str:
    """Why an effect's columns are not known at one instant; empty where they are."""
    if effect.offline:
        return effect.offline
    if effect.beyond_state:
        return f"it depends on {effect.beyond_state[0].split('_')[0]}, which no motion chooses"
    if effect.keeps:
        return "it depends on the motion before, and a design is judged instant by instant"
    return "" if effect.has_physics else "it names no physics: it stays as it was found"


def for_design(known: KnownTorqueModel) -> KnownTorqueModel:
    """A model without what no motion can be designed for; the rest is known as well as before."""
    whole = known.torque_model
    kept = [(e, place) for e, place in with_columns(whole.effects) if not _reason(e)]
    columns = np.concatenate([np.arange(place.start, place.stop) for _, place in kept])
    rest = dataclasses.replace(whole, effects=tuple(e for e, _ in kept), measurement=())
    covariance = known.covariance[np.ix_(columns, columns)]
    return KnownTorqueModel(rest, known.parameters[columns], covariance)


def completing(problem: DesignProblem, known: KnownTorqueModel) -> DesignProblem:
    """The problem of a motion that narrows what a model leaves in doubt.

    A covariance is in the units of real noise, and so the motion's rows must be: R_v is what currents
    leave unexplained, a share of the torque that each drive is made for.

    Args:
        problem: Of the model's effects, without a covariance of its own.
        known: The same model's numbers.
    """
    return dataclasses.replace(
        problem,
        covariance=(NOISE * drive_sizes(problem)) ** 2,
        prior=known_information(problem.base, known.covariance),
    )


def known_information(
    base: BaseParameters, covariance: Float[ndarray, "parameters parameters"]
) -> Float[ndarray, "base base"]:
    """Information about base parameters that a covariance of all parameters stands for.

    A base parameter of no variance was not estimated: nothing is known of it.

    Args:
        base: Which of the columns.
        covariance: (p, p), zero where a parameter was not estimated.
    """
    whole = base.regrouping @ covariance @ base.regrouping.T
    std = np.sqrt(np.diag(whole).clip(min=0.0))
    told = np.flatnonzero(std > 0)
    information = np.zeros_like(whole)
    scale = np.outer(std[told], std[told])
    block = whole[np.ix_(told, told)] / scale
    information[np.ix_(told, told)] = np.linalg.pinv(block, rcond=RANK, hermitian=True) / scale
    return information
