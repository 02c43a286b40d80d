"""Effects that are as far as their name goes."""

from __future__ import annotations

import numpy as np

from oed.diagnosis.evidence.verdict import FoundEffect
from oed.diagnosis.tables.workshop import Workshop
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.effects.position import TorqueRipple

# Of the range of a shape: where it ends, and what deviation tells that it is there.
AT_END, KNOWN = 0.005, 0.1
OVERTONES = 0.3  # of a wave, from which on it is more than one


def is_at_its_end(shop: Workshop, effect: FoundEffect) -> bool:
    """Whether an effect would be something that its name does not say, if it were let.

    A loop wider than any presliding is none, but a narrower one is; waves as long as a ripple's may
    be, to a deviation and without overtones, are any function of position. A load that is taken up as
    the recordings begin, to a deviation, or as they end is what a start or a stop does. Else of a
    joint alone, and not where the shape is unknown: a change in time may be slower than a recording
    is long, and a filter slower than any is one.
    """
    trial = effect.trial
    if isinstance(trial.effect, PayloadChange):
        moment, *_ = CATALOGUE[trial.name].shapes_for(shop.context, trial.target)
        std = next((p.std for p in effect.parameters if p.name == moment.name), 0.0)
        value = trial.values[0]
        return min(value - moment.lower, moment.upper - value) < std
    if trial.joint is None or trial.between_repetitions:
        return False
    shapes = CATALOGUE[trial.name].shapes_for(shop.context, trial.target)
    if not shapes or not (shapes[0].scale == "log" or shapes[0].ends_below):
        return False
    first, value = shapes[0], trial.values[0]
    std = next(p.std for p in effect.parameters if p.name == first.name) / first.slope_at(value)
    place = first.place_of(value)
    if first.scale == "log":
        is_there = place > 1 - AT_END or (place < AT_END and not first.open_below)
    else:
        is_there = place < std and not _comes_back(effect)
    return is_there and std < KNOWN


def _comes_back(effect: FoundEffect) -> bool:
    """Whether a ripple has overtones, of which more periods lie within the motion."""
    ripple = effect.trial.effect
    if not isinstance(ripple, TorqueRipple):
        return False
    sizes = [p.value for p in effect.parameters[: 2 * len(ripple.harmonics)]]
    waves = np.linalg.norm(np.reshape(sizes, (-1, 2)), axis=1)
    shorter = np.array(ripple.harmonics) > ripple.harmonics[0]
    return bool(np.linalg.norm(waves[shorter]) > OVERTONES * waves[0])
