"""Covariance of all linear parameters of a fitted model, in the order of its predictor."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.evidence.model import Fitted
from oed.diagnosis.evidence.moments import correlated_rows


def parameter_covariance(whole: Fitted) -> Float[ndarray, "parameters parameters"]:
    """By the scores of blocks of rows, which may depend on one another within a block.

    Liang and Zeger 1986, "Longitudinal data analysis using generalized linear models", Biometrika
    73(1). Shapes are taken as they are. Parameters that are not columns of the fit have zeros.

    Args:
        whole: The fitted model.
    """
    projection = whole.projection
    rows, used = whole.problem.rows, projection.used
    correlated = max(correlated_rows(whole, j, used) for j in range(rows.joints))
    blocks = rows.blocks(correlated)[used]
    scores = np.einsum("jub,ju->ub", projection.basis, projection.span.left)
    by_block = np.zeros((int(blocks.max()) + 1, scores.shape[1]))
    np.add.at(by_block, blocks, scores)
    half = projection.inverse @ by_block.T
    return _placed(whole, half @ half.T)


def _placed(
    whole: Fitted, covariance: Float[ndarray, "columns columns"]
) -> Float[ndarray, "parameters parameters"]:
    """Columns of the fit to where the predictor has them."""
    count, places, own = len(whole.installed.parameters), [], list(range(len(whole.columns)))
    places += [int(column) for column in whole.columns]
    for term, effect, place in zip(whole.terms, whole.effects, whole.places, strict=True):
        if effect is not None and not term.steps:
            width = place.stop - place.start
            places += range(count, count + width)
            own += range(place.start, place.stop)
            count += width
    result = np.zeros((count, count))
    result[np.ix_(places, places)] = covariance[np.ix_(own, own)]
    return result
