"""What a diagnosis leaves in doubt, where its headline would not say so."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.inference.answer import FoundEffect
from oed.diagnosis.numbers import CLEAR
from oed.report.joint_words import place_words


def names_of(effect: FoundEffect) -> str:
    """Name and place of an effect, with those that give the same torque on the recordings.

    Such as "filter_lag or time_delay (arm)".
    """
    members = [(effect.name, effect.joint)]
    # Of a smooth term that gives the same torque nothing is claimed.
    members += [
        (a.name, a.joint)
        for a in effect.alternatives
        if a.same and a.open and a.name != "smooth term"
    ]
    places: dict[str, list[str]] = {}
    for name, joint in members:
        places.setdefault(place_words(joint), []).append(name)
    return " or ".join(f"{' or '.join(names)} ({place})" for place, names in places.items())


def far_off(errors: Float[ndarray, " joints"], floor: Float[ndarray, " joints"]) -> str:
    """Joints of which a model predicts less than the noise allows, for the end of a sentence."""
    ratio = errors / floor
    told = ", ".join(f"joint {j + 1} ({ratio[j]:.2g})" for j in np.flatnonzero(ratio > CLEAR))
    return f"; above {CLEAR:g} noise floors: {told}" if told else ""
