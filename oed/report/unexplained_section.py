"""The section of a diagnosis' page on what is there and has no name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.diagnosis import Diagnosis
from oed.diagnosis.evidence.proof import error_in_floors
from oed.diagnosis.evidence.unlocated import CLEAR_UNSEEN
from oed.diagnosis.evidence.verdict import Unexplained
from oed.diagnosis.evidence.withheld import MOSTLY, SURELY
from oed.dynamics.effects.smooth_term import FreeForm
from oed.report.page import Picture, Table, Text

LOST = (
    "Where no term describes what is left, a further recording tells more than these: one motion "
    "five times or more, so that noise and what changes with time stand apart, and the same path "
    "at half the speed, which parts what follows position from what follows speed. What only the "
    "test recordings show asks for recordings to estimate from that move as they do."
)
OWN_TIME = (
    "What keeps its own time is not the same at every repetition: it is part of the noise floor, "
    "and no model of the motion foretells it. Its share is of what the repetitions differ by, of "
    "the residual where no motion is repeated."
)
WITHHELD = (
    "What a name of the catalogue fits best, beside a free-form term of its joint, is not claimed "
    f"to be that where it explains less than {SURELY:.3g} times what the joint still lacks of the "
    "validation recordings, where its name alone foretells nothing, or where all additions explain "
    f"less than {MOSTLY:.3g} times what the joint still lacks of the test recordings. It makes the "
    "model better, and may be a part of something else."
)
UNCERTAIN = (
    "The estimation recordings leave parameters so uncertain that on the validation recordings "
    "errors of more than the noise are to be expected, and tell little; a motion that excites all "
    "of them (studies.design) would. In brackets the error to be expected, in noise floors:"
)
FAR_OFF = 4.0  # times the expected validation error, from which on a mistake in the file is likely
MISTAKES = (
    "So large an error is more often a mistake in the files than physics. Worth a look: signs and "
    "order of the columns, angles that count from the link before or from the base, zero "
    "positions, gravity's direction, the values in [drive], and whether q and tau belong to the "
    "same instant."
)


def unexplained_blocks(found: Diagnosis, labels: Sequence[str]) -> list[Text | Table | Picture]:
    """Free-form terms, and what is said of errors that no term explains.

    Args:
        found: The diagnosis.
        labels: Of the joints.
    """
    blocks: list[Text | Table | Picture] = []
    seen, ratios = (
        error_in_floors(found.proof, found.noise_floor, role)
        for role in ("estimation", "validation")
    )
    # Noise is as loud there as where the model was fitted.
    expected = np.maximum(seen, 1.0) * found.expected
    unseen = [
        f"{label} ({ratio:.2g})"
        for label, ratio, own in zip(labels, ratios, expected, strict=True)
        if ratio > CLEAR_UNSEEN * own
    ]
    open_ = [
        f"{label} ({own:.2g})"
        for label, own in zip(labels, found.expected, strict=True)
        if own > CLEAR_UNSEEN
    ]
    if open_:
        blocks.append(Text(f"{UNCERTAIN} {', '.join(open_)}."))
    if unseen:
        blocks.append(
            Text(
                "On the validation recordings what the model predicts is not what happens at "
                f"{', '.join(unseen)}; in brackets the error in noise floors."
            )
        )
    if not any(p.period for p in found.shop.estimation):
        blocks.append(
            Text(
                "No motion is repeated: what changes with time cannot be told from what depends "
                "on the motion, and a drift may be part of the noise floor. What is left counts "
                "where it keeps step with the arm; slow noise, which does not, may exceed the floor."
            )
        )
    if np.any(ratios > FAR_OFF * expected):
        blocks.append(Text(MISTAKES))
    if not found.unexplained:
        return [*blocks, Text("No free-form term of the residual is significant.")]
    rows = [
        {
            "joint": labels[u.joint],
            "term": u.label,
            "share of residual variance": f"{u.share:.0%}",
            "part of the model": _standing(u),
        }
        for u in found.unexplained
    ]
    if not all(u.depends_on for u in found.unexplained):
        blocks.append(Text(LOST))
    if any(u.depends_on and u.trial is None for u in found.unexplained):
        blocks.append(Text(OWN_TIME))
    if any(u.trial is not None and not u.trial.is_free_form for u in found.unexplained):
        blocks.append(Text(WITHHELD))
    caption = (
        "Free-form terms that the data demand: functions of positions q, velocities dq and "
        "accelerations ddq of the joints numbered, or of time; tau is a share of another joint's "
        "torque."
    )
    return [*blocks, Table(rows, caption)]


def _standing(item: Unexplained) -> str:
    if item.stands_in:
        effect = None if item.trial is None else item.trial.effect
        ends = isinstance(effect, FreeForm) and effect.visited is not None
        return "yes, as far as the arm has been" if ends else "yes"
    return "no: does not predict unseen motion" if item.depends_on else "no"
