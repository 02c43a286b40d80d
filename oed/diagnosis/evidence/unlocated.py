"""Joints of which too much is left, though no term locates it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.chance import keeps_step, keeps_step_unseen
from oed.diagnosis.evidence.lack_of_fit import LackOfFit, foretold_error
from oed.diagnosis.evidence.verdict import Unexplained
from oed.diagnosis.evidence.withheld import Errors
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.unseen import Unseen
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial
from oed.experiment.preparation.prepared import Prepared

# Ratio of the error on recordings that no parameter was fitted to, to what may be expected of them,
# above which something is missing though no term locates it.
CLEAR_UNSEEN = 2.0
# Beyond which it is none, whatever noise does: slow noise was read too low by 2.4 at most.
NO_FLOOR = 3.0


def unlocated(
    shop: Workshop,
    chosen: tuple[Trial, ...],
    located: Sequence[Unexplained],
    left: LackOfFit,
    errors: Errors,
) -> Iterator[Unexplained]:
    """What is missing beyond doubt, though nothing says what.

    Without repetitions noise that changes slowly may be louder than its floor. So what keeps no
    step with the arm counts only where it is far louder, and is then said to be of time.

    Args:
        shop: The laid-out data.
        chosen: Additions.
        located: What terms say.
        left: Lack of fit of the augmented model.
        errors: Of that model.
    """
    # Noise is as loud there as where the model was fitted, slow noise too.
    foretold = np.maximum(errors.seen, 1.0) * expected_unseen(shop, chosen)
    for found in describe_unlocated(
        located, left, errors.seen, errors.unseen / foretold, shop.settings
    ):
        j = found.joint
        if keeps_step(shop, chosen, j):
            yield found
        elif min(errors.seen[j], errors.unseen[j]) > NO_FLOOR:
            yield replace(found, depends_on=("time",), label="slow, in no step with the arm")
        elif errors.seen[j] > max(NO_FLOOR, CLEAR_UNSEEN * errors.unseen[j]) and errors.unseen[j]:
            yield replace(found, depends_on=("time",), label="while the fitted motions ran alone")
        elif (
            errors.seen[j] > NO_FLOOR
            or errors.unseen[j] > NO_FLOOR * foretold[j]
            or (errors.unseen[j] > CLEAR_UNSEEN and keeps_step_unseen(shop, chosen, j))
        ):
            yield found


def shown_by_test(
    shop: Workshop,
    chosen: tuple[Trial, ...],
    located: Sequence[Unexplained],
    errors: Errors,
    test: tuple[Prepared, ...],
) -> Iterator[Unexplained]:
    """Joints that the test recordings alone show to lack something.

    They may go where no other does, and there is no term to be sought in what must stay unseen. But
    that nothing is missing, or that all is explained, is not said of an error that no noise makes.

    Args:
        shop: The laid-out data.
        chosen: Additions.
        located: All that is without a name.
        errors: Of the augmented model.
        test: The recordings.
    """
    if not test:
        return
    unseen = Unseen.of(shop.baseline, test, mean=False)
    foretold = _foretold(shop, chosen, unseen)
    ratios = errors.after / (np.maximum(errors.seen, 1.0) * foretold)
    for joint in sorted(set(np.flatnonzero(ratios > NO_FLOOR)) - {u.joint for u in located}):
        share = 1 - 1 / float(errors.after[joint]) ** 2
        yield Unexplained(
            int(joint), (), share, "what only the test recordings show", stands_in=False
        )


def expected_unseen(shop: Workshop, chosen: Sequence[Trial]) -> Float[ndarray, " joints"]:
    """(n,) validation error that noise and parameters it leaves uncertain let expect, in floors."""
    return _foretold(shop, chosen, shop.unseen_full)


def _foretold(shop: Workshop, chosen: Sequence[Trial], unseen: Unseen) -> Float[ndarray, " joints"]:
    inverse = shop.fit(chosen, bend=False).fit.projection.inverse
    return foretold_error(inverse, unseen.white, unseen.counted)


def describe_unlocated(
    located: Sequence[Unexplained],
    left: LackOfFit,
    seen: Float[ndarray, " joints"],
    unseen: Float[ndarray, " joints"],
    settings: DiagnosisSettings,
) -> tuple[Unexplained, ...]:
    """Joints of which too much is left, and of no term that was tried.

    A lack of fit counts only where the error shows it too: what is clear in the mean of many
    repetitions may be little beside the noise of any, and a floor that was not read off
    repetitions is itself uncertain by some tenths.

    Args:
        located: What terms say; their joints are not named again.
        left: Lack of fit of the augmented model.
        seen: (n,) its error on the estimation recordings, in noise floors.
        unseen: (n,) that on the validation recordings, over what noise and uncertain parameters
            let expect; zero without them.
        settings: Level of the tests.
    """
    clear = (left.p_value < settings.level) & (seen > settings.floor_ratio)
    missing = set(np.flatnonzero(clear | (unseen > CLEAR_UNSEEN))) - {u.joint for u in located}
    shares = 1 - 1 / np.maximum(np.maximum(seen, unseen), 1.0) ** 2
    return tuple(
        Unexplained(int(j), (), float(shares[j]), "no term that was tried", stands_in=False)
        for j in sorted(missing)
    )
