"""Whether a robot file's inertials are its maker's numbers, or there to fill the file.

Files that were written to show or to steer an arm hold inertials that keep a parser content: a unit
matrix, one kilogram for all, the same ball at every link. Such numbers are no prior. The test asks
what no designed arm has, and needs no list of known placeholders.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.robot.inertia import pseudo_inertia
from oed.robot.robot import Robot

# Relative spread of the principal moments below which a tensor is that of a ball: a drive with its
# housing is no ball, and files that were computed from a drawing differ in the second digit.
ROUND = 1e-3
# Relative difference of mass and moments below which two links are the same numbers.
ALIKE = 1e-3
OSMIUM = 22_590.0  # [kg/m^3] the densest matter (CRC Handbook of Chemistry and Physics)
SHORTEST_REACH = 0.3  # [m] of an arm whose joint frames share an origin


def placeholder_reasons(robot: Robot) -> tuple[str, ...]:
    """Why the inertials of a robot's file are not taken for the arm's; empty if they may be.

    Args:
        robot: As loaded from its file.

    Returns:
        One line for each kind of evidence, with the links concerned.
    """
    bodies = robot.parameters.reshape(-1, 10)
    links = [joint.link for joint in robot.joints]
    if robot.inertia_faults:
        return tuple(fault.text for fault in robot.inertia_faults)
    weightless = [link for link, body in zip(links, bodies, strict=True) if not body[0] > 0]
    if weightless:
        return (f"no mass is given for {', '.join(weightless)}",)
    spreads = np.array([_spread(body) for body in bodies])
    if np.any(spreads <= 0):
        flat = [link for link, spread in zip(links, spreads, strict=True) if spread.min() <= 0]
        return (f"no body with volume has the inertia of {', '.join(flat)}",)
    return tuple(
        reason
        for reason in (
            _too_dense(links, bodies[:, 0], spreads),
            _too_wide(links, spreads, robot),
            _balls(links, spreads),
            _same_for_all(bodies[:, 0], spreads),
        )
        if reason
    )


def _spread(body: Float[ndarray, "10"]) -> Float[ndarray, "3"]:
    """Principal variances of the mass about its centre [m^2], ascending."""
    pseudo = pseudo_inertia(body)
    centre = pseudo[:3, 3] / body[0]
    return np.linalg.eigvalsh(pseudo[:3, :3] / body[0] - np.outer(centre, centre))


def _too_dense(
    links: list[str], masses: Float[ndarray, " n"], spreads: Float[ndarray, "n 3"]
) -> str:
    # Of all bodies with a given covariance of mass the uniform ellipsoid, with semi-axes
    # sqrt(5 variance), reaches it at the least density.
    volume = 4 / 3 * np.pi * np.prod(np.sqrt(5 * spreads), axis=1)
    dense = [k for k in range(len(links)) if masses[k] / volume[k] > OSMIUM]
    if not dense:
        return ""
    worst = max(dense, key=lambda k: masses[k] / volume[k])
    return (
        f"{links[worst]} would be of {masses[worst] / volume[worst]:.3g} kg/m^3 or more, denser than "
        "any matter"
    )


def _too_wide(links: list[str], spreads: Float[ndarray, "n 3"], robot: Robot) -> str:
    reach = max(
        SHORTEST_REACH, float(sum(np.linalg.norm(joint.p_PJ) for joint in robot.joints[1:]))
    )
    radius = np.sqrt(spreads[:, -1])
    worst = int(radius.argmax())
    if radius[worst] <= reach:
        return ""
    return (
        f"the mass of {links[worst]} would be spread over {radius[worst]:.3g} m, the arm reaches "
        f"{reach:.3g} m"
    )


def _balls(links: list[str], spreads: Float[ndarray, "n 3"]) -> str:
    is_round = spreads[:, -1] - spreads[:, 0] <= ROUND * spreads[:, -1]
    if is_round.sum() <= len(links) / 2:
        return ""
    return f"{is_round.sum()} of {len(links)} links have the inertia of a ball"


def _same_for_all(masses: Float[ndarray, " n"], spreads: Float[ndarray, "n 3"]) -> str:
    numbers = np.column_stack([masses, spreads])
    if len(numbers) < 2 or np.any(np.abs(numbers - numbers[0]) > ALIKE * numbers[0]):
        return ""
    return f"all {len(numbers)} links have the same mass and inertia"
