"""How far a set of links is from its reference: two measures, with value and derivatives.

The entropic one is the log-det (Bregman) divergence of pseudo-inertias, twice the relative
entropy of the Gaussian distributions of mass that they describe. It does not depend on the
links' frames, and grows without bound at the boundary of consistency (Lee, Wensing and
Park 2020, "Geometric robot dynamic identification: a convex programming approach"). The
quadratic one is the plain distance of parameters, each in a unit of its link's size.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.feasible.coordinates import BASIS, ENTRIES, IDENTITY, Coordinates, adjoint
from oed.estimation.feasible.weight_range import LEAST_WEIGHT, MOST_WEIGHT

RegularisationKind = Literal["entropic", "quadratic"]


@dataclass(frozen=True)
class Regularisation:
    """A pull towards the reference bodies.

    Attributes:
        weight: Rise of the mean squared weighted residual that a unit of distance is worth.
        kind: "entropic" or "quadratic".
    """

    weight: float
    kind: RegularisationKind = "entropic"

    def __post_init__(self) -> None:
        if not LEAST_WEIGHT <= self.weight <= MOST_WEIGHT:
            raise ValueError(
                f"regularisation weight {self.weight:g} must be from {LEAST_WEIGHT:g} to "
                f"{MOST_WEIGHT:g}: without any, parameters that no torque depends on have no value"
            )
        if self.kind not in ("entropic", "quadratic"):
            raise ValueError(f"regularisation {self.kind!r} is neither entropic nor quadratic")

    def value(self, coordinates: Coordinates, x: Float[ndarray, " p"]) -> float:
        """Distance from the reference; inf where a link is not consistent (entropic)."""
        if self.kind == "quadratic":
            return float(np.sum((quadratic_root(coordinates) @ (x - coordinates.start)) ** 2) / 2)
        inertias = coordinates.relative_inertias(x)
        eigenvalues = np.linalg.eigvalsh(inertias)
        if not np.all(eigenvalues > 0):
            return np.inf
        return float(np.sum(eigenvalues - np.log(eigenvalues) - 1.0))

    def gradient(self, coordinates: Coordinates, x: Float[ndarray, " p"]) -> Float[ndarray, " p"]:
        """Gradient of `value`."""
        if self.kind == "quadratic":
            root = quadratic_root(coordinates)
            return root.T @ (root @ (x - coordinates.start))
        inverse = np.linalg.inv(coordinates.relative_inertias(x))
        result = np.zeros(len(x))
        result[: ENTRIES * coordinates.links] = np.tile(IDENTITY, coordinates.links) - adjoint(
            inverse
        )
        return result

    def hessian(self, coordinates: Coordinates, x: Float[ndarray, " p"]) -> Float[ndarray, "p p"]:
        """Second derivatives of `value`."""
        if self.kind == "quadratic":
            root = quadratic_root(coordinates)
            return root.T @ root
        result = np.zeros((len(x), len(x)))
        for link, block in enumerate(log_det_hessians(coordinates.relative_inertias(x))):
            place = slice(ENTRIES * link, ENTRIES * link + ENTRIES)
            result[place, place] = block
        return result


def log_det_hessians(matrices: Float[ndarray, "links 4 4"]) -> Float[ndarray, "links 10 10"]:
    """Second derivatives of -log det by the coordinates of each matrix."""
    inverse = np.linalg.inv(matrices)
    turned = np.einsum("lij,kjm->lkim", inverse, BASIS)
    return np.einsum("lkim,lhmi->lkh", turned, turned)


def quadratic_root(coordinates: Coordinates) -> Float[ndarray, "inertial p"]:
    """F with |F (x - x_0)|^2 the squared distance of parameters, in units of the link's size.

    The units are m_0 for a mass, m_0 l for a first moment and m_0 l^2 for an inertia, with
    l^2 the reference body's polar second moment per mass.
    """
    inertial = ENTRIES * coordinates.links
    units = []
    for m, _, _, _, xx, _, _, yy, _, zz in coordinates.reference.reshape(-1, ENTRIES):
        length = np.sqrt((xx + yy + zz) / 2 / m)
        units.append(m * np.array([1.0, *(length,) * 3, *(length**2,) * 6]))
    return coordinates.to_parameters[:inertial] / np.concatenate(units)[:, None]
