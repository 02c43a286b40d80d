"""What else could have been named in the place of an effect that was found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.candidates.judgement import held_out_fault
from oed.diagnosis.candidates.margin import decisive_between, is_of_kind
from oed.diagnosis.candidates.open_shapes import decided
from oed.diagnosis.candidates.ranking import ranked
from oed.diagnosis.candidates.telling import telling
from oed.diagnosis.candidates.turning import GRAVITY, turned
from oed.diagnosis.search.tilt_review import stood_upright
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.scores import Score, implausible, inflation_of, score
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.linear_fit import LinearFit
from oed.dynamics.effects.actuator import GainError
from oed.dynamics.effects.catalogue import CATALOGUE

RIVALS = 5
# Of the gain of what was found, from which on the shape of another is refined: no less comes near.
WITHIN_REACH = 0.5
SAME_COLUMNS = 0.9995  # correlation beside the model above which two effects are one on any data


@dataclass(frozen=True)
class Rival:
    """Another effect in the place of one that was found.

    Attributes:
        name: Of the catalogue.
        joint: Index, None for the whole arm.
        evidence: By how much the found one is better, on the estimation and the validation
            recordings: -2 log likelihood less Schwarz's penalty, in units of the misfit.
        trial: Its columns, for the design that will tell.
        contender: Whether that difference is too small to tell, and it passes all tests that
            the found one passed.
        margin: By how much one of the two must be better to be the one that is meant.
        is_same: Whether it is the found effect by another joint's name: its torques are the same
            beside the model, on any data.
    """

    name: str
    joint: int | None
    evidence: float
    trial: Trial
    contender: bool
    margin: float
    is_same: bool = False


def find_rivals(shop: Workshop, own: Accepted, others: list[Trial]) -> tuple[Rival, ...]:
    """The best other candidates for the place of an addition, beside the rest."""
    if own.trial.name == GRAVITY and shop.is_turned:
        return _rivals_of_tilt(shop, others)
    layout = shop.layout(own.trial)
    fit = shop.fit(others, layout).fit
    here = score(shop.renewed(own.trial), fit)
    least = WITHIN_REACH * here.gain
    other = [
        found
        for found in ranked(shop, _in_place_of(shop, own.trial), others, RIVALS, least=least)
        if found.trial.key != own.trial.key
    ]
    candidates = [decided(shop, others, s) if s.gain > least else s for s in other[:RIVALS]]
    (said, *others_said), unit = telling(shop, others, [here, *candidates])
    rivals = []
    for found, value in zip(candidates, others_said, strict=True):
        behind = said - value
        margin = decisive_between(shop, here, found, unit)
        is_same = _is_same(found, here, fit)
        may_be = bool(behind < margin) and not is_same
        contender = may_be and _contends(shop, found, here, others)
        trial = found.trial
        rival = Rival(trial.name, trial.joint, float(behind), trial, contender, margin, is_same)
        rivals.append(rival)
    return tuple(rivals)


def _in_place_of(shop: Workshop, trial: Trial) -> list[Trial]:
    """Candidates that act on a joint on which an addition acts, and gains of any joint with a gain.

    Too small a gain of one is too large a gain of all others.
    """
    near = shop.in_place_of(trial)
    if not isinstance(trial.effect, GainError):
        return near
    gains = [t for t in shop.physical if isinstance(t.effect, GainError)]
    return near + [t for t in gains if set(t.group).isdisjoint(trial.group)]


def _rivals_of_tilt(shop: Workshop, others: list[Trial]) -> tuple[Rival, ...]:
    """What explains as much on the tables that a tilt has turned, as long as they are not turned."""
    upright, levelled = stood_upright(shop, others)
    cost = 2 * np.log(shop.full.rows.count)
    rivals = []
    for found in ranked(upright, upright.physical, levelled, RIVALS)[: RIVALS + 1]:
        if found.trial.name == GRAVITY:
            continue
        chosen = [*levelled, found.trial]
        tilted = shop.fit(others, shop.layout_for(chosen), bend=False)
        other = upright.fit(chosen, bend=False)
        unseen = [s.unseen_by(chosen) for s in (shop, upright)]
        foretold = [u.left(fit) for u, fit in zip(unseen, (tilted, other), strict=True)]
        unit = np.maximum(foretold[0] / unseen[0].counted, 1.0)
        chance = float(inflation_of(tilted.fit).mean())
        behind = float(
            (other.fit.squares - tilted.fit.squares) / chance
            + np.sum((foretold[1] - foretold[0]) / unit)
            + found.price(shop.full.rows.count)
            - cost
        )
        contender = (
            behind < shop.settings.decisive
            and implausible(found, upright.context) is None
            and held_out_fault(upright, levelled, found.trial) is None
        )
        trial = found.trial
        margin = shop.settings.decisive
        rivals.append(Rival(trial.name, trial.joint, behind, trial, contender, margin))
    return tuple(rivals)


def _contends(shop: Workshop, rival: Score, own: Score, others: list[Trial]) -> bool:
    """Whether a rival passes the tests, and is none that holds the found effect."""
    if implausible(rival, shop.context) is not None:
        return False
    if own.trial.name in CATALOGUE[rival.trial.name].holds and is_of_kind(own.trial, rival.trial):
        return False
    if held_out_fault(shop, others, rival.trial) is not None:
        return False
    # Its columns may explain what no tilt of possible links does. On tables of its own: to turn
    # them settles the torque that all effects refer to.
    return rival.trial.name != GRAVITY or turned(shop.on(shop.baseline), others).is_turned


def _is_same(rival: Score, own: Score, fit: LinearFit) -> bool:
    if rival.trial.name != own.trial.name:
        return False
    return _likeness(rival, own, fit) >= SAME_COLUMNS


def _likeness(a: Score, b: Score, fit: LinearFit) -> float:
    """Cosine between two fitted additions outside the model's span."""
    joints, rows = fit.residual.shape
    vectors = []
    for item in (a, b):
        torque = np.zeros((joints, rows))
        if any(block.shape[0] != rows for block in item.trial.group.values()):
            return 0.0
        for joint, block in item.trial.group.items():
            torque[joint] = block @ item.coefficients
        vectors.append(fit.projection.residual(torque).ravel())
    lengths = [float(np.linalg.norm(v)) for v in vectors]
    return abs(float(vectors[0] @ vectors[1])) / max(lengths[0] * lengths[1], 1e-300)
