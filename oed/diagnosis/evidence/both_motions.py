"""What the validation recordings add to what is known of a shape that they decided.

A shape that both motions decide lies where the likelihoods of both are largest together, its sizes
where the estimation recordings want them at that shape. So the information on the shape adds up,
and the sizes follow it as they do in the fit. What the fit does not know of all other parameters
is an error of the foretold torque too, and the same for all its rows. That the shapes' errors then
make up in part for those of the sizes holds as far as slopes are straight, and is not counted on.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray


def narrowed(
    covariance: Float[ndarray, "parameters parameters"],
    shapes: slice,
    slopes: Float[ndarray, "rows parameters"],
    misfit: Float[ndarray, " rows"],
) -> Float[ndarray, "parameters parameters"]:
    """Covariance of a fit whose shapes an unseen motion decided with it.

    Args:
        covariance: Of the fit alone.
        shapes: Those that were decided.
        slopes: Change of the unseen motion's white rows with every parameter.
        misfit: Variance of what the fit leaves of them, at least that of the noise.
    """
    own = covariance[shapes, shapes]
    follow = covariance[:, shapes] @ np.linalg.pinv(own, hermitian=True)
    rest = covariance - follow @ own @ follow.T
    # Of the shapes themselves nothing is left but rounding, which may be a negative variance.
    rest[shapes] = rest[:, shapes] = 0.0
    along = slopes @ follow
    weighed = along / misfit[:, None]
    told, shared = along.T @ weighed, slopes.T @ weighed
    fitted = np.linalg.pinv(own, hermitian=True)
    both = np.linalg.pinv(fitted + told, hermitian=True)
    decided = both @ (fitted + told + shared.T @ rest @ shared) @ both
    return rest + follow @ decided @ follow.T
