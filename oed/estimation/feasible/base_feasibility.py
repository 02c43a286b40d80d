"""Is there any feasible robot behind given base parameters?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.feasible.coordinates import ENTRIES, Coordinates
from oed.estimation.feasible.feasible_set import (
    FeasibleSet,
    Rows,
    equality_rows,
    inequality_rows,
)
from oed.estimation.feasible.interior import TAKES_PART, Certificate, most_interior
from oed.estimation.feasible.reference import neutral_bodies

# A sign may be met exactly, as by a joint without friction: this is rounding of the solver.
ROUNDING = 1e-8


@dataclass(frozen=True)
class BaseFeasibility:
    """The answer, with its proof.

    Attributes:
        margin: Largest margin of any parameters with these base values, relative to the
            reference bodies; negative if none is feasible.
        example: (p,) the parameters with that margin: an example if it is positive.
        certificate: That no parameters have a larger margin.
        blamed: What the certificate weighs, heaviest first: links by name, and signs.
    """

    margin: float
    example: Float[ndarray, " p"]
    certificate: Certificate
    blamed: tuple[str, ...]

    @property
    def is_feasible(self) -> bool:
        """Whether a feasible robot has these base parameters."""
        return self.margin > -ROUNDING


def base_feasibility(
    model: TorqueModel,
    base: BaseParameters,
    values: Float[ndarray, " base"],
    *,
    demands: FeasibleSet | None = None,
    reference: Float[ndarray, " inertial"] | None = None,
) -> BaseFeasibility:
    """Look for standard parameters with given base parameters, as deep inside as there are.

    Sousa and Cortesao 2014 ask this of every base estimate. Infeasible ones are proven so by
    the dual: weights Y_i for which sum_i <Y_i, J_i> is a combination of base parameters alone,
    and negative, though for any consistent links it could not be.

    Args:
        model: Whose base parameters they are.
        base: The regrouping.
        values: (b,) to be examined.
        demands: `FeasibleSet.of(model)` if None; its margin is not used.
        reference: (10 n,) bodies to measure the margin against; neutral ones if None.

    Raises:
        SolverFailed: If the solver finds neither an example nor a proof.
    """
    demands = demands or FeasibleSet.of(model)
    reference = neutral_bodies(model.robot) if reference is None else reference
    inertial = ENTRIES * model.robot.n
    sizes = np.abs(base.to_standard(values))[inertial:]
    typical = np.median(sizes[sizes > 0]) if np.any(sizes > 0) else 1.0
    coordinates = Coordinates.relative_to(reference, np.where(sizes > 0, sizes, typical))
    inequality = inequality_rows(demands, model)
    known = equality_rows(demands, model)
    equality = Rows(
        np.vstack([base.regrouping, known.matrix]),
        np.concatenate([values, known.bound]),
        (*base.names, *known.names),
    )
    scaled = [_in_unknowns(rows, coordinates) for rows in (inequality, equality)]
    inner = most_interior(coordinates, *scaled)
    return BaseFeasibility(
        margin=inner.margin,
        example=coordinates.parameters(inner.x),
        certificate=inner.certificate,
        blamed=_blamed(inner.certificate, model, inequality.names),
    )


def _in_unknowns(rows: Rows, coordinates: Coordinates) -> Rows:
    matrix = rows.matrix @ coordinates.to_parameters
    lengths = np.linalg.norm(matrix, axis=1)
    return Rows(matrix / lengths[:, None], rows.bound / lengths, rows.names)


def _blamed(
    certificate: Certificate, model: TorqueModel, names: tuple[str, ...]
) -> tuple[str, ...]:
    shares = [
        *zip(certificate.links, (joint.link for joint in model.robot.joints), strict=True),
        *zip(certificate.inequality, names, strict=True),
    ]
    return tuple(name for share, name in sorted(shares, reverse=True) if share > TAKES_PART)
