"""What an estimate makes of the robot file's links: before, after, and whether the data asked for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import svd

from oed.estimation.feasible.coordinates import ENTRIES
from oed.estimation.feasible.problem import FeasibleProblem
from oed.robot.inertia import pseudo_inertia

# A mass beyond this factor of the file's is reported: makers' masses of whole links agree with
# identified ones within some ten per cent where both are told apart (Gaz and others 2019, Panda).
FACTOR = 2.0
# Standard deviation, per value, up to which least squares on the data alone determine it.
DETERMINED = 0.3
# Share of a unit vector outside the data's row space that is taken for rounding.
OUTSIDE = 1e-4
RANK = 1e-8  # of the largest singular value of columns of unit length


@dataclass(frozen=True)
class LinkChange:
    """One link, or all of them together, in the file and as identified.

    Attributes:
        link: Its name; "all links" for the sum.
        mass_before: In the file [kg].
        mass_after: As identified [kg].
        interval: (2) of that mass [kg].
        deviation: Standard deviation of the mass by least squares on the data alone [kg], inf
            where they do not depend on it.
        centre_before: (3) centre of mass in the file, body frame [m]; None for the sum.
        centre_after: (3) as identified [m]; None for the sum.
        inertia_before: (3) principal moments about the centre of mass in the file [kg m^2].
        inertia_after: (3) as identified [kg m^2].
    """

    link: str
    mass_before: float
    mass_after: float
    interval: Float[ndarray, "2"]
    deviation: float
    centre_before: Float[ndarray, "3"] | None = None
    centre_after: Float[ndarray, "3"] | None = None
    inertia_before: Float[ndarray, "3"] | None = None
    inertia_after: Float[ndarray, "3"] | None = None

    @property
    def is_determined(self) -> bool:
        """Whether the data alone determine the mass."""
        return self.deviation <= DETERMINED * abs(self.mass_after)

    @property
    def is_unreasonable(self) -> bool:
        """Whether the mass moved by more than a factor without the data determining it."""
        ratio = self.mass_after / self.mass_before
        return not self.is_determined and not 1 / FACTOR <= ratio <= FACTOR

    @property
    def warning(self) -> str:
        """What moved, in words."""
        low, high = self.interval
        known = (
            "no torque in the data depends on it by itself"
            if not np.isfinite(self.deviation)
            else f"the data alone leave it uncertain by {self.deviation:.3g} kg"
        )
        return (
            f"{self.link}: {self.mass_after:.3g} kg, in the file {self.mass_before:.3g} kg (95 % of "
            f"resampled estimates: {low:.3g} to {high:.3g} kg), and {known}: believe the file, state "
            "--total-mass or raise --weight"
        )


def link_changes(
    links: tuple[str, ...],
    before: Float[ndarray, " inertial"],
    after: Float[ndarray, " inertial"],
    samples: Float[ndarray, "r p"],
    problem: FeasibleProblem,
    *,
    level: float = 0.95,
) -> tuple[LinkChange, ...]:
    """Each link's change, and that of the total mass.

    Args:
        links: (n,) names.
        before: (10 n,) the file's.
        after: (10 n,) the estimate's.
        samples: Estimates from resampled data.
        problem: Whose data say what they determine.
        level: Of the intervals.
    """
    inertial = len(after)
    masses = np.arange(0, inertial, ENTRIES)
    tail = 50 * (1 - level)
    weights = [np.eye(len(masses))[k] for k in range(len(masses))] + [np.ones(len(masses))]
    combinations = np.zeros((len(weights), problem.coordinates.size))
    combinations[:, masses] = weights
    deviations = deviations_from_data(problem, combinations)
    changes = []
    for k, (weight, deviation) in enumerate(zip(weights, deviations, strict=True)):
        own = slice(ENTRIES * k, ENTRIES * k + ENTRIES)
        is_link = k < len(links)
        old, new = (_body(p[own]) if is_link else (None, None) for p in (before, after))
        changes.append(
            LinkChange(
                link=links[k] if is_link else "all links",
                mass_before=float(weight @ before[masses]),
                mass_after=float(weight @ after[masses]),
                interval=np.percentile(samples[:, masses] @ weight, [tail, 100 - tail]),
                deviation=float(deviation),
                centre_before=old[0],
                centre_after=new[0],
                inertia_before=old[1],
                inertia_after=new[1],
            )
        )
    return tuple(changes)


def deviations_from_data(
    problem: FeasibleProblem, combinations: Float[ndarray, "k p"]
) -> Float[ndarray, " k"]:
    """Standard deviations of combinations of parameters by least squares, without demand or pull.

    Args:
        problem: Its weighted data; a row is taken to have a variance of one.
        combinations: (k, p) rows over the parameters, in their units.

    Returns:
        (k,) in the combinations' units, inf where they leave the data's row space.
    """
    rows = combinations @ problem.coordinates.to_parameters
    lengths = np.linalg.norm(problem.factor, axis=0)
    used = lengths > 0
    # By QR iteration: LAPACK's divide and conquer, NumPy's choice, fails on some triangles.
    _, values, right = svd(
        problem.factor[:, used] / lengths[used], full_matrices=False, lapack_driver="gesvd"
    )
    kept = values > RANK * values[0]
    scaled = rows[:, used] / lengths[used]
    along = scaled @ right[kept].T
    outside = np.linalg.norm(scaled - along @ right[kept], axis=1) > OUTSIDE * np.linalg.norm(
        scaled, axis=1
    )
    outside |= np.any(np.abs(rows[:, ~used]) > 0, axis=1)
    deviations = np.linalg.norm(along / values[kept], axis=1) / np.sqrt(problem.rows)
    return np.where(outside, np.inf, deviations)


def _body(parameters: Float[ndarray, "10"]) -> tuple[ndarray, ndarray]:
    """Centre of mass and principal moments about it."""
    pseudo = pseudo_inertia(parameters)
    centre = pseudo[:3, 3] / parameters[0]
    spread = pseudo[:3, :3] - parameters[0] * np.outer(centre, centre)
    return centre, np.linalg.eigvalsh(np.trace(spread) * np.eye(3) - spread)
