"""What each addition does: what is missing without it, and what it gives, over its coordinates.

Both are differences between fits of all parameters, so that what the other columns of the model
take over belongs to neither. They are known where an effect's own parameters are not: of friction
beside friction the data tell the sum.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.turning import GRAVITY
from oed.diagnosis.evidence.dependence import Dependence, binned, blocks_of, coordinates_of
from oed.diagnosis.evidence.final_model import FinalModel, errors_of, final_with
from oed.diagnosis.search.selected import Selection
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.experiment.preparation.prepared import Prepared

CELLS = 14  # of a map, each way
LEAST_ROWS = 3  # in a cell
OUTER = (0.005, 0.995)  # quantiles between which a map is drawn


@dataclass(frozen=True)
class ContributionCurve:
    """An addition over one coordinate.

    Attributes:
        label: Name of the effect, or the free-form term in words.
        missing: Residual of the joint where all but this addition is fitted.
        given: Torque of this addition that the rest of the model cannot give.
    """

    label: str
    missing: Dependence
    given: Dependence


@dataclass(frozen=True)
class ContributionMap:
    """An addition over two coordinates.

    Attributes:
        label: The free-form term in words.
        joint: Index.
        coordinates: Such as ("q_1", "dq_2").
        edges: Of the cells, one array a coordinate.
        given: (C, C) mean torque in each cell that the rest of the model cannot give, first
            coordinate first; NaN where the motion does not come [N m].
    """

    label: str
    joint: int
    coordinates: tuple[str, str]
    edges: tuple[Float[ndarray, " edges"], Float[ndarray, " edges"]]
    given: Float[ndarray, "cells cells"]


Contribution = ContributionCurve | ContributionMap


def contributions(
    shop: Workshop, selection: Selection, after: FinalModel, floor: Float[ndarray, " joints"]
) -> tuple[Contribution, ...]:
    """Every addition on the estimation recordings, one that only says where something is too.

    Args:
        shop: The laid-out data.
        selection: The additions.
        after: The model with those that are part of it.
        floor: (n,) noise floor [N m], by which joints are compared.
    """
    prepared = shop.estimation
    whole = np.concatenate(errors_of(after, prepared))
    measured = _measured(prepared)
    standing = list(selection.trials)

    def errors(chosen: Sequence[Trial]) -> Float[ndarray, "rows joints"]:
        return np.concatenate(errors_of(final_with(shop, shop.fit(chosen)), prepared))

    found = []
    for item in selection.accepted:
        trial = item.trial
        if trial.name == GRAVITY and shop.is_turned:
            continue
        if item.stands_in:
            without = errors([t for t in standing if t is not trial])
            remaining = whole
        else:
            without, remaining = whole, errors([*standing, trial])
        given = without - remaining
        joint = trial.joint
        if joint is None:
            joint = int(np.argmax(np.sum(given**2, axis=0) / floor**2))
        found.append(_shown(trial, joint, measured, (without, given), prepared))
    return tuple(found)


def _measured(prepared: Sequence[Prepared]) -> dict[str, Float[ndarray, " rows"]]:
    """Every coordinate over which an addition may be drawn, in the analysis band."""
    torque = np.concatenate([p.torque[p.valid] for p in prepared])
    torques = {f"tau_{j + 1}": torque[:, j] for j in range(torque.shape[1])}
    return coordinates_of(prepared) | torques


def _shown(
    trial: Trial,
    joint: int,
    measured: Mapping[str, Float[ndarray, " rows"]],
    errors: tuple[Float[ndarray, "rows joints"], Float[ndarray, "rows joints"]],
    prepared: Sequence[Prepared],
) -> Contribution:
    without, given = (e[:, joint] for e in errors)
    own = [name for name in trial.effect.depends_on if name in measured]
    label, blocks = str(trial.key[0]), blocks_of(prepared)
    if trial.is_free_form and len(own) == 2:
        return _map(label, joint, (own[0], own[1]), measured, given)
    own = own or [f"{kind}_{joint + 1}" for kind in ("q", "dq", "ddq")]
    drawn = [binned(joint, name, measured[name], given, blocks) for name in own]
    best = max(drawn, key=lambda d: d.share)
    x = measured[best.coordinate]
    return ContributionCurve(label, binned(joint, best.coordinate, x, without, blocks), best)


def _map(
    label: str,
    joint: int,
    names: tuple[str, str],
    measured: Mapping[str, Float[ndarray, " rows"]],
    given: Float[ndarray, " rows"],
) -> ContributionMap:
    first, second = (measured[name] for name in names)
    edges = _edges(first), _edges(second)
    count, _, _ = np.histogram2d(first, second, bins=edges)
    total, _, _ = np.histogram2d(first, second, bins=edges, weights=given)
    mean = np.where(count >= LEAST_ROWS, total / np.maximum(count, 1), np.nan)
    return ContributionMap(label, joint, names, edges, mean)


def _edges(x: Float[ndarray, " rows"]) -> Float[ndarray, " edges"]:
    lower, upper = np.quantile(x, OUTER)
    return np.linspace(lower, upper, CELLS + 1)
