"""Where the joints went, by role, within the limits of the robot's file."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from oed.experiment.dataset import DataSet
from oed.experiment.recording import ROLES
from oed.report.style import BLUE, GREY, ORANGE, PURPLE, STYLE, new_figure

WIDTH = 5.0  # [in] legible on a telephone
ROW_HEIGHT = 0.42  # [in]
COLOURS: dict[str, str] = dict(zip(ROLES, (BLUE, ORANGE, PURPLE), strict=True))


def draw_ranges(dataset: DataSet) -> Figure:
    """A bar a role and joint from the lowest to the highest position; grey: the limits."""
    with mpl.rc_context(STYLE):
        return _draw(dataset)


def _draw(dataset: DataSet) -> Figure:
    joints = dataset.robot.joints
    figure = new_figure(WIDTH, 0.9 + ROW_HEIGHT * len(joints))
    panel = figure.subplots()
    limits = dataset.robot.limits.position
    roles = [role for role in ROLES if any(r.role == role for r in dataset.recordings)]
    height = 0.7 / len(roles)
    for j in range(len(joints)):
        if np.isfinite(limits[j]).all():
            panel.barh(j, np.ptp(limits[j]), left=limits[j, 0], height=0.86, color=GREY, alpha=0.25)
    for k, role in enumerate(roles):
        q = np.concatenate([r.q for r in dataset.recordings if r.role == role])
        middle = np.arange(len(joints)) - 0.35 + height * (k + 0.5)
        panel.barh(
            middle,
            np.ptp(q, axis=0),
            left=q.min(axis=0),
            height=0.85 * height,
            color=COLOURS[role],
            label=role,
        )
    panel.set_yticks(range(len(joints)), [joint.name for joint in joints], parse_math=False)
    panel.invert_yaxis()
    slides = any(joint.kind == "prismatic" for joint in joints)
    panel.set_xlabel("position [rad, m at prismatic joints]" if slides else "position [rad]")
    figure.legend(loc="outside upper center", ncols=len(roles))
    return figure
