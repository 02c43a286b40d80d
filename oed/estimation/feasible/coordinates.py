"""Unknowns without units: each link's pseudo-inertia relative to a reference body.

With the reference J_0 = L L^T, the unknown of a link is J^ = L^-1 J L^-T. Positive definiteness
is kept by this congruence, the reference itself becomes the identity, and parameters that span
many orders of magnitude become numbers around one. J^ does not depend on the link's frame, so
neither do margins that are stated in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import block_diag

from oed.robot.inertia import parameters_from_pseudo_inertia, pseudo_inertia

ENTRIES = 10  # of a symmetric 4 x 4 matrix, and inertial parameters of a link


def _symmetric_basis() -> Float[ndarray, "10 4 4"]:
    """Orthonormal basis of the symmetric 4 x 4 matrices."""
    basis = np.zeros((ENTRIES, 4, 4))
    for k, (row, column) in enumerate(zip(*np.triu_indices(4), strict=True)):
        basis[k, row, column] = basis[k, column, row] = 1.0 if row == column else np.sqrt(0.5)
    return basis


BASIS = _symmetric_basis()
IDENTITY = np.einsum("kii->k", BASIS)  # coordinates of the identity matrix


@dataclass(frozen=True)
class Coordinates:
    """The linear map pi = T x between parameters and unknowns.

    Attributes:
        reference: (10 n,) parameters of the reference bodies, each physically consistent.
        to_parameters: (p, p) T, block-diagonal: ten by ten a link, then one an effect.
    """

    reference: Float[ndarray, " inertial"]
    to_parameters: Float[ndarray, "p p"]

    @classmethod
    def relative_to(
        cls,
        reference: Float[ndarray, " inertial"],
        effect_scales: Float[ndarray, " effects"],
    ) -> Coordinates:
        """Unknowns relative to reference bodies.

        Args:
            reference: (10 n,) inertial parameters of a consistent body for each link.
            effect_scales: Size of each further parameter, in its unit.

        Raises:
            ValueError: If a reference body is not physically consistent, or a scale is not
                positive.
        """
        blocks = []
        for link, parameters in enumerate(reference.reshape(-1, ENTRIES)):
            try:
                root = np.linalg.cholesky(pseudo_inertia(parameters))
            except np.linalg.LinAlgError as error:
                raise ValueError(
                    f"the reference of link {link + 1} is not physically consistent"
                ) from error
            congruent = root @ BASIS @ root.T
            blocks.append(np.column_stack([parameters_from_pseudo_inertia(c) for c in congruent]))
        if not np.all(effect_scales > 0):
            raise ValueError("every scale of an effect's parameter must be positive")
        to_parameters = np.asarray(block_diag(*blocks, np.diag(effect_scales)))
        return cls(np.asarray(reference, dtype=float), to_parameters)

    @property
    def links(self) -> int:
        """Number of links n."""
        return len(self.reference) // ENTRIES

    @property
    def size(self) -> int:
        """Number of parameters p."""
        return len(self.to_parameters)

    @property
    def start(self) -> Float[ndarray, " p"]:
        """Unknowns of the reference bodies, with effects at one scale each."""
        return np.concatenate(
            [np.tile(IDENTITY, self.links), np.ones(self.size - ENTRIES * self.links)]
        )

    def parameters(self, x: Float[ndarray, " p"]) -> Float[ndarray, " p"]:
        """Parameters pi in their units."""
        return self.to_parameters @ x

    def unknowns(self, parameters: Float[ndarray, " p"]) -> Float[ndarray, " p"]:
        """Unknowns x of parameters."""
        return np.linalg.solve(self.to_parameters, parameters)

    def relative_inertias(self, x: Float[ndarray, " p"]) -> Float[ndarray, "links 4 4"]:
        """J^ of every link."""
        return np.tensordot(x[: ENTRIES * self.links].reshape(-1, ENTRIES), BASIS, axes=1)


def adjoint(matrices: Float[ndarray, "links 4 4"]) -> Float[ndarray, " inertial"]:
    """Gradient by x of sum_i <matrices_i, J^_i>."""
    return np.einsum("lij,kij->lk", matrices, BASIS).reshape(-1)
