"""Free-form terms that stand in for what has no name."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from oed.diagnosis.free_form import FreeForm
from oed.diagnosis.judgement import Accepted, Refused, held_out_fault, judge
from oed.diagnosis.ranking import ranked
from oed.diagnosis.restraint import restrained
from oed.diagnosis.trials import Trial, free_form_trials
from oed.diagnosis.workshop import Workshop

# Ratio of the held-out error that a free-form term must reach: it knows nothing of physics that
# would carry it to the next motion.
BETTER = 0.95


def next_free_form(
    shop: Workshop, accepted: list[Accepted], refused: list[Refused]
) -> Accepted | None:
    """The best term that passes all tests, with what of it may predict; None if none does."""
    others = [a.trial for a in accepted]
    pool = (*shop.smooth, *shop.smooth_pairs)
    candidates = ranked(shop, pool, others, shop.settings.refined)
    for candidate in candidates:
        if candidate.evidence(shop.full.rows.count) <= shop.settings.free_form_margin:
            break
        passed = judge(shop, candidate, accepted, pool, refused)
        if passed is not None:
            return _standing_in(shop, passed, others)
    return None


def _standing_in(shop: Workshop, item: Accepted, others: Sequence[Trial]) -> Accepted:
    """A free-form term as far as the data determine it, part of the model if it then predicts."""
    joint = item.trial.joint
    found = shop.fit(others, shop.layout(item.trial))
    plain = shop.validation_rms(found)
    size = shop.size_of_residual(found, joint)
    choices = [
        trial
        for whole in (item.trial, *_finer(shop, item.trial))
        for trial in restrained(whole, found.fit, size)
    ]
    ratios = [0.0] * len(choices)
    if plain is not None:
        fits = (shop.fit([*others, t], shop.layout(t), bend=False) for t in choices)
        ratios = [float(shop.validation_rms(fit)[joint] / plain[joint]) for fit in fits]
    for ratio, trial in sorted(zip(ratios, choices, strict=True), key=lambda pair: pair[0]):
        if ratio >= BETTER:
            break
        if held_out_fault(shop, others, trial) is None:
            return dataclasses.replace(item, trial=trial, stands_in=True)
    return dataclasses.replace(item, stands_in=False)


def _finer(shop: Workshop, trial: Trial) -> list[Trial]:
    """The term with twice the pieces: what was noticed may be finer than what noticed it."""
    effect = trial.effect
    if not isinstance(effect, FreeForm):
        return []
    term = dataclasses.replace(effect, coordinates=tuple(c.halved() for c in effect.coordinates))
    return free_form_trials([term], shop.layout(trial).rows, contrast=trial.contrast)
