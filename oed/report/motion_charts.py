"""A motion against the limits of the arm, joint by joint, to look into."""

from __future__ import annotations

from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.report.chart import Chart, Trace, line, panel_axis, points_for, stacked_panels
from oed.report.colours import BLUE, VERMILION
from oed.robot import JointLimits, Robot

SIGNALS = (
    ("position", "q", "rad"),
    ("velocity", "dq", "rad/s"),
    ("acceleration", "ddq", "rad/s^2"),
)
FAR = 1.6  # a limit further off than this many times the motion's own reach is not drawn


def motion_charts(
    robot: Robot,
    limits: JointLimits,
    motion: Motion,
    torque: Float[ndarray, "samples joints"] | None = None,
) -> tuple[Chart, ...]:
    """One chart a quantity, a panel a joint.

    Args:
        robot: The arm.
        limits: To draw where they are near.
        motion: N samples.
        torque: (N, n) along it [N m, N at prismatic joints]; None where there is none.
    """
    signals = [(kind, getattr(motion, field), unit) for kind, field, unit in SIGNALS]
    if torque is not None:
        signals.append(("torque", torque, "N m"))
    points = points_for(len(signals) * robot.n)
    charts = []
    for kind, values, unit in signals:
        units = [joint.unit(unit) for joint in robot.joints]
        traces: list[Trace] = [
            line(
                motion.t, values[:, j], points, name=kind, showlegend=False, yaxis=panel_axis(j),
                line={"color": BLUE, "width": 1.2},
                hovertemplate=f"%{{y:.4g}} {units[j]} at %{{x:.3f}} s<extra></extra>",
            )
            for j in range(robot.n)
        ]  # fmt: skip
        titles = [f"{name} [{u}]" for name, u in zip(robot.joint_names, units, strict=True)]
        axes, height = stacked_panels(titles, "time [s]", has_legend=False)
        shapes = [
            shape
            for j in range(robot.n)
            for shape in _bounds(j, values[:, j], getattr(limits, kind)[j])
        ]
        caption = f"{kind.capitalize()} of every joint; limits are dashed where they are near."
        charts.append(Chart(traces, {**axes, "shapes": shapes}, caption, height))
    return tuple(charts)


def _bounds(joint: int, values: ndarray, limit: ndarray) -> list[dict[str, object]]:
    middle, reach = (values.max() + values.min()) / 2, (values.max() - values.min()) / 2
    return [
        {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "yref": panel_axis(joint)}
        | {"y0": float(bound), "y1": float(bound), "line": {"color": VERMILION, "dash": "dash"}}
        for bound in limit
        if abs(bound - middle) <= FAR * reach
    ]
