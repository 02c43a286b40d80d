"""A designed motion against its limits."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
from jaxtyping import Float
from matplotlib.figure import Figure
from numpy import ndarray

from oed.design.limits import Certificate
from oed.dynamics.motion import Motion
from oed.report.style import BLUE, GREY, PAGE, STYLE, VERMILION, new_figure
from oed.robot import JointLimits

SIGNALS = (("position", "q", "rad"), ("velocity", "dq", "rad/s"), ("acceleration", "ddq", "rad/s²"))
FAR = 1.6  # a limit further off than this many times the motion's own reach is not drawn
PANEL_HEIGHT = 1.0  # [in]


def draw_motion(
    motion: Motion,
    joint_names: Sequence[str],
    limits: JointLimits,
    certificate: Certificate,
    torque: Float[ndarray, "samples joints"] | None = None,
) -> Figure:
    """Position, velocity, acceleration and torque of every joint, a row a joint.

    Limits are dashed; the shaded band is what the certificate proves the motion stays within.

    Args:
        motion: Sampled finely.
        joint_names: (n,) names.
        limits: To be kept.
        certificate: Proven bounds.
        torque: (N, n) nominal torque [N m], where there is a nominal model.
    """
    with mpl.rc_context(STYLE):
        return _draw(motion, joint_names, limits, certificate, torque)


def _draw(
    motion: Motion,
    joint_names: Sequence[str],
    limits: JointLimits,
    certificate: Certificate,
    torque: ndarray | None,
) -> Figure:
    n = len(joint_names)
    columns = 3 if torque is None else 4
    figure = new_figure(PAGE, 0.6 + PANEL_HEIGHT * n)
    panels = figure.subplots(n, columns, sharex=True, squeeze=False)
    signals = [(kind, getattr(motion, field), unit) for kind, field, unit in SIGNALS]
    if torque is not None:
        signals.append(("torque", torque, "N m"))
    for column, (kind, values, unit) in enumerate(signals):
        proven = getattr(certificate, kind)
        panels[0, column].set_title(f"{kind} [{unit}]")
        for joint, panel in enumerate(panels[:, column]):
            _draw_panel(panel, motion.t, values[:, joint], getattr(limits, kind)[joint])
            if proven is not None:
                panel.axhspan(*proven[joint], color=BLUE, alpha=0.08, linewidth=0)
    for joint, name in enumerate(joint_names):
        panels[joint, 0].set_ylabel(name, parse_math=False)
    for panel in panels[-1]:
        panel.set_xlabel("t [s]")
    return figure


def _draw_panel(panel, t: ndarray, values: ndarray, limit: ndarray) -> None:
    panel.plot(t, values, color=BLUE)
    panel.axhline(0.0, color=GREY, linewidth=0.5)
    middle, reach = (values.max() + values.min()) / 2, (values.max() - values.min()) / 2
    for bound in limit:
        if abs(bound - middle) <= FAR * reach:
            panel.axhline(bound, color=VERMILION, linestyle="--", linewidth=0.8)
    panel.margins(x=0)
