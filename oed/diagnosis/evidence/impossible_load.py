"""A load that was named and that no body can be."""

from __future__ import annotations

from oed.diagnosis.evidence.uncertainty import at_given_shapes
from oed.diagnosis.tables.workbench import Augmented
from oed.diagnosis.terms.bodies import is_no_body
from oed.diagnosis.terms.trials import Trial


def impossible_load(whole: Augmented) -> Trial | None:
    """A named load whose parameters no body has, with the uncertainty that is told of them."""
    for trial, coefficients, covariance in zip(
        whole.chosen, whole.coefficients, whole.covariances, strict=True
    ):
        if is_no_body(trial, coefficients, at_given_shapes(covariance, len(coefficients))):
            return trial
    return None
