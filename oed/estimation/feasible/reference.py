"""Bodies to measure links against: the prior's, or neutral ones where there is no prior."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import OedError, RobotError
from oed.robot import Robot
from oed.robot.inertia import parameters_from_pseudo_inertia, pseudo_inertia
from oed.robot.placeholder_inertia import placeholder_reasons

# A neutral body is a rod from the link's joint to the next with this radius of gyration across,
# per length: stout as arm links are.
STOUTNESS = 0.25
SHORTEST = 0.01  # [m]: joint frames closer than this share an origin, as in a wrist
FALLBACK_LENGTH = 0.3  # [m] where the kinematics has no length at all
# Least eigenvalue of a prior's pseudo-inertia, per that of a neutral body of the same mass, that
# still counts as a body with volume: a prior thinner than that is not one to divide by.
THINNEST = 1e-6


class InfeasiblePrior(OedError):
    """A prior whose links no distribution of mass can have.

    Attributes:
        links: Indices of the links at fault.
        margins: (n,) least eigenvalue of each link's pseudo-inertia relative to a neutral body.
    """

    def __init__(self, message: str, links: tuple[int, ...], margins: ndarray) -> None:
        super().__init__(message)
        self.links = links
        self.margins = margins


def neutral_bodies(robot: Robot) -> Float[ndarray, " inertial"]:
    """Consistent parameters (10 n,) from the kinematics alone, at one kilogram a typical length.

    Each link is a rod from its joint to the mean of the joints that it carries, as long as a
    typical link where there are none, with a mass proportional to its length.
    """
    offsets = [np.linalg.norm(joint.p_PJ) for joint in robot.joints if joint.parent >= 0]
    lengths = [length for length in offsets if length > SHORTEST]
    typical = float(np.mean(lengths)) if lengths else FALLBACK_LENGTH
    bodies = []
    for i in range(robot.n):
        ends = [joint.p_PJ for joint in robot.joints if joint.parent == i]
        end = np.mean(ends, axis=0) if ends else np.zeros(3)
        length = max(float(np.linalg.norm(end)), typical)
        bodies.append(_rod(length / typical, end, STOUTNESS * length))
    return np.concatenate(bodies)


def scaled_neutral_bodies(
    robot: Robot, factor: Float[ndarray, "p p"], target: Float[ndarray, " p"]
) -> Float[ndarray, " inertial"]:
    """Neutral bodies of the one density that explains the data best.

    Args:
        robot: Its kinematics shape the bodies.
        factor: R of the weighted data.
        target: z, so that |R pi - z| is the part of the residual that depends on pi.
    """
    bodies = neutral_bodies(robot)
    inertial = len(bodies)
    columns = np.column_stack([factor[:, :inertial] @ bodies, factor[:, inertial:]])
    norms = np.linalg.norm(columns, axis=0)
    used = norms > 0
    density = np.linalg.lstsq(columns[:, used] / norms[used], target, rcond=None)[0][0] / norms[0]
    # Data that see no inertia, or want a negative one, say nothing of the density.
    return bodies * (density if used[0] and density > 0 else 1.0)


@dataclass(frozen=True)
class FileInertials:
    """The inertials of a robot's file as a prior.

    Attributes:
        prior: (10 n,) to be pulled to; None for neutral bodies.
        known: (10 n,) to be compared with; None where the file's are placeholders that nobody
            asked for.
        reason: Why, in one line.
    """

    prior: Float[ndarray, " inertial"] | None
    known: Float[ndarray, " inertial"] | None
    reason: str


def file_inertials(robot: Robot, *, wanted: bool | None = None) -> FileInertials:
    """Take the file's inertials for a prior where they may be the arm's.

    Args:
        robot: As loaded from its file.
        wanted: True takes them though they look like placeholders, False never does, None
            decides by `placeholder_reasons`.

    Raises:
        RobotError: If they are wanted, and the file has none or impossible ones.
    """
    reasons = placeholder_reasons(robot)
    if wanted and robot.inertia_faults:
        raise RobotError(
            f"--prior: {robot.inertia_faults[0].text}; correct the robot's file, or leave it out"
        )
    known = None if reasons else robot.parameters
    if wanted:
        doubt = f", though {reasons[0]}" if reasons else ""
        return FileInertials(
            robot.parameters, robot.parameters, f"the robot file's inertials, as asked{doubt}"
        )
    if wanted is None and not reasons:
        return FileInertials(
            known, known, "the robot file's inertials, which may be its maker's numbers"
        )
    why = (
        "as asked" if not reasons else f"the robot file's inertials are placeholders: {reasons[0]}"
    )
    return FileInertials(None, known, f"neutral bodies; {why}")


def require_consistent(robot: Robot, prior: Float[ndarray, " inertial"]) -> None:
    """Refuse a prior that is no set of bodies.

    Raises:
        InfeasiblePrior: Naming the links whose pseudo-inertia is not positive definite.
    """
    margins = np.array(
        [
            _relative_margin(mine, body)
            for mine, body in zip(
                prior.reshape(-1, 10), neutral_bodies(robot).reshape(-1, 10), strict=True
            )
        ]
    )
    wrong = tuple(int(i) for i in np.flatnonzero(~(margins > THINNEST)))
    if wrong:
        named = ", ".join(
            f"{robot.joints[i].link} (least eigenvalue {margins[i]:.2g} of a solid body's)"
            for i in wrong
        )
        raise InfeasiblePrior(
            f"the prior is not physically consistent: no distribution of mass has the inertia "
            f"of {named}",
            wrong,
            margins,
        )


def _relative_margin(parameters: Float[ndarray, "10"], body: Float[ndarray, "10"]) -> float:
    mass = parameters[0]
    if not mass > 0:
        return float(min(mass, 0.0))
    root = np.linalg.cholesky(pseudo_inertia(body) * mass / body[0])
    relative = np.linalg.solve(root, np.linalg.solve(root, pseudo_inertia(parameters)).T)
    return float(np.linalg.eigvalsh(relative)[0])


def _rod(mass: float, end: Float[ndarray, "3"], radius: float) -> Float[ndarray, "10"]:
    centre = end / 2
    spread = np.outer(end, end) / 12 + radius**2 * np.eye(3)
    pseudo = np.empty((4, 4))
    pseudo[:3, :3] = mass * (spread + np.outer(centre, centre))
    pseudo[:3, 3] = pseudo[3, :3] = mass * centre
    pseudo[3, 3] = mass
    return parameters_from_pseudo_inertia(pseudo)
