"""Whether the sizes of an arm are numbers that can be computed with."""

from __future__ import annotations

import numpy as np

from oed.errors import RobotError
from oed.largest_number import LARGEST
from oed.robot.merged_tree import MergedTree


def check_sizes(where: str, tree: MergedTree) -> None:
    """Refuse lengths and inertias whose products no double holds."""
    for joint, body in zip(tree.joints, tree.parameters.reshape(-1, 10), strict=True):
        far = float(np.abs([joint.p_PJ, joint.p_LJ]).max())
        if not far <= LARGEST:
            raise RobotError(
                f"{where}: joint {joint.name!r} lies {far:.3g} m off, and nothing of an arm is above "
                f"{LARGEST:g} in SI units; correct its <origin> or <pose>"
            )
        heavy = float(np.abs(body).max())
        if not heavy <= LARGEST:
            raise RobotError(
                f"{where}: link {joint.link!r} has a mass, centre of mass or inertia of {heavy:.3g}, and "
                f"nothing of an arm is above {LARGEST:g} in SI units; correct it"
            )
