"""What of a free-form term the data determine: the rest is left out, so that it cannot run away.

A spline beside a rigid-body model has combinations of its functions that the model nearly
makes itself. Least squares gives them large values that cancel on the motion at hand and on no
other. A combination stays only where the data know it far better than what was expected before
tells: the hard-threshold form of a ridge (Hoerl and Kennard 1970, Technometrics 12(1)), where
functions of any shape are expected alike, or of a smoothing spline (Demmler and Reinsch 1975,
Numerische Mathematik 24), where smooth ones are, which also carry over to what lies between.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import eigh

from oed.diagnosis.fit.linear_fit import LinearFit, gram_and_moment
from oed.diagnosis.terms.free_form import FreeForm
from oed.diagnosis.terms.trials import Trial

# Standard deviations that a function of the residual's size must measure, from what noise alone
# asks for to what a motion that leaves much of the range unvisited does.
KNOWN = (2.0, 6.0, 20.0, 60.0)
# Weight of a coefficient's square against that of its difference from the next; None for no
# differences at all.
FLATNESS: tuple[float | None, ...] = (None, 0.03)


def restrained(trial: Trial, fit: LinearFit, size: float) -> Iterator[Trial]:
    """The term with its determined combinations alone, ever fewer of them.

    Args:
        trial: A free-form term, its group on the rows of the fit.
        fit: Of the model before it.
        size: Of what is to be explained [N m].

    Raises:
        TypeError: If the trial is no free-form term.
    """
    effect = trial.effect
    if not isinstance(effect, FreeForm):
        raise TypeError(f"{trial.name} is no free-form term")
    (gram, _), _ = gram_and_moment(fit.projection, fit.residual, trial.group)
    for flatness in FLATNESS:
        expected = expectation(effect, flatness)
        values, vectors = eigh(gram, expected)
        for known in KNOWN:
            kept = values * size**2 > known**2
            if not kept.any():
                break
            mixing = vectors[:, kept]
            group = {joint: block @ mixing for joint, block in trial.group.items()}
            yield dataclasses.replace(
                trial, effect=dataclasses.replace(effect, mixing=mixing), group=group
            )


def expectation(effect: FreeForm, flatness: float | None) -> Float[ndarray, "functions functions"]:
    """Inverse covariance of the coefficients of a unit function that is expected.

    Args:
        effect: Splines in one or two coordinates, or a loop.
        flatness: As in `FLATNESS`.
    """
    counts = [c.functions for c in effect.coordinates]
    size = int(np.prod(counts))
    if flatness is None or effect.remembers:
        return np.eye(size)
    inverse = flatness * np.eye(size)
    for axis, count in enumerate(counts):
        steps = np.diff(np.eye(count), axis=0)
        before, after = (int(np.prod(part)) for part in (counts[:axis], counts[axis + 1 :]))
        along = np.kron(np.kron(np.eye(before), steps), np.eye(after))
        inverse += along.T @ along
    return inverse * float(np.mean(np.diag(np.linalg.inv(inverse))))
