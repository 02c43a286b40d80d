"""A load to look at: on the arm, and close by with its centre of mass and principal axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.newton_euler import joint_pose
from oed.estimation.load.payload import Payload
from oed.estimation.load.quantities import central_inertia
from oed.report.chart import Chart, Trace, plain
from oed.report.colours import BLUE, GREY, VERMILION
from oed.robot import Robot

HEIGHT = 420  # [px]
OUTLINE = 73  # points of an ellipse
VIEWS = (("x", "z", (0, 2)), ("y", "z", (1, 2)))
MILLIMETRES = 1e3


def load_on_arm_chart(payload: Payload) -> Chart:
    """The arm in the middle of its recording, from the side and from above, with the load.

    Args:
        payload: To draw.
    """
    motion = payload.equations.recordings[0].motion
    points, R_WF, p_WF = _posture(payload.model.arm.robot, motion.q[len(motion) // 2], payload)
    centre = p_WF + R_WF @ payload.centre
    spread = R_WF @ _spread(payload) @ R_WF.T
    traces: list[Trace] = []
    for panel, (_, _, axes) in enumerate((VIEWS[0], ("x", "y", (0, 1)))):
        own = _panel(panel)
        path = np.vstack([points, p_WF])[:, axes]
        traces += [
            _line(path, "arm", GREY, panel, mode="lines+markers", width=5.0) | own,
            _line(_outline(centre, spread, axes), "load", BLUE, panel) | own,
            _dot(centre[list(axes)], "centre of mass", panel) | own,
        ]
    layout = _two_panels(("x [m]", "z [m]"), ("x [m]", "y [m]"))
    caption = (
        "The arm in the middle of the recording, from the side and from above; the load as the "
        "ellipsoid of one density that has its mass and inertia."
    )
    return Chart(traces, layout, caption, HEIGHT)


def load_chart(payload: Payload) -> Chart:
    """The load about its frame, with 95 % intervals of the centre and the principal axes [mm].

    Args:
        payload: To draw.
    """
    spread = _spread(payload) * MILLIMETRES**2
    centre = payload.centre * MILLIMETRES
    lengths, directions = np.linalg.eigh(spread)
    traces: list[Trace] = []
    for panel, (first, second, axes) in enumerate(VIEWS):
        own = _panel(panel)
        traces.append(
            _line(np.zeros((1, 2)), payload.frame.name, GREY, panel, mode="markers") | own
        )
        traces.append(_line(_outline(centre, spread, axes), "load", BLUE, panel) | own)
        for axis in range(3):
            half = np.sqrt(5 * max(lengths[axis], 0.0)) * directions[:, axis]
            ends = np.array([centre - half, centre + half])[:, axes]
            name = "principal axes" if axis == 0 else ""
            traces.append(_line(ends, name, BLUE, panel, width=1.0, dash="dot") | own)
        bars = {
            f"error_{way}": _bar(payload, letter)
            for way, letter in (("x", first), ("y", second))
            if payload[letter].interval is not None
        }
        traces.append({**_dot(centre[list(axes)], "centre of mass", panel), **bars, **own})
    name = plain(payload.frame.name)
    layout = _two_panels((f"x of {name} [mm]", "z [mm]"), (f"y of {name} [mm]", "z [mm]"))
    caption = (
        "The load about its frame; bars are 95 % intervals of the centre of mass, dotted the "
        "principal axes of inertia."
    )
    return Chart(traces, layout, caption, HEIGHT)


def _posture(
    robot: Robot, q: Float[ndarray, " joints"], payload: Payload
) -> tuple[Float[ndarray, "points 3"], Float[ndarray, "3 3"], Float[ndarray, "3"]]:
    """Origins of the bodies on the way to the load, and the pose of its frame in the base."""
    way, joint = [payload.frame.joint], payload.frame.joint
    while (joint := robot.joints[joint].parent) >= 0:
        way.insert(0, joint)
    R, p, points = np.eye(3), np.zeros(3), [np.zeros(3)]
    for j in way:
        R_PJ, p_PJ = joint_pose(robot.joints[j], float(q[j]))
        p, R = p + R @ np.array(p_PJ), R @ np.array(R_PJ)
        points.append(p)
    return np.array(points), R @ payload.frame.R_JF, p + R @ payload.frame.p_JF


def _spread(payload: Payload) -> Float[ndarray, "3 3"]:
    """Second moment of the mass about its centre, per mass, in the frame [m^2]."""
    inertia = central_inertia(payload.parameters)
    return (np.trace(inertia) / 2 * np.eye(3) - inertia) / payload.mass


def _outline(
    centre: Float[ndarray, "3"], spread: Float[ndarray, "3 3"], axes: tuple[int, int]
) -> Float[ndarray, "points 2"]:
    """Of the solid ellipsoid of this spread, whose half axes are sqrt(5) standard deviations."""
    seen = spread[np.ix_(axes, axes)]
    values, vectors = np.linalg.eigh(seen)
    turn = np.linspace(0, 2 * np.pi, OUTLINE)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    half = vectors * np.sqrt(5 * np.maximum(values, 0.0))
    return centre[list(axes)] + circle @ half.T


def _bar(payload: Payload, letter: str) -> dict[str, Any]:
    quantity = payload[letter]
    low, high = quantity.interval or (quantity.value, quantity.value)
    return {
        "type": "data",
        "symmetric": False,
        "array": [MILLIMETRES * (high - quantity.value)],
        "arrayminus": [MILLIMETRES * (quantity.value - low)],
        "color": VERMILION,
    }


def _line(
    points: Float[ndarray, "points 2"],
    name: str,
    colour: str,
    panel: int,
    *,
    mode: str = "lines",
    width: float = 2.0,
    dash: str = "solid",
) -> dict[str, Any]:
    shown = {"name": plain(name), "legendgroup": name, "showlegend": bool(name) and panel == 0}
    return {
        "type": "scatter", "mode": mode, "x": points[:, 0], "y": points[:, 1], **shown,
        "line": {"color": colour, "width": width, "dash": dash}, "marker": {"color": colour, "size": 8},
        "hovertemplate": "%{x:.4g}, %{y:.4g}" + (f" {plain(name)}" if name else "") + "<extra></extra>",
    }  # fmt: skip


def _dot(point: Float[ndarray, "2"], name: str, panel: int) -> dict[str, Any]:
    return _line(point[None], name, VERMILION, panel, mode="markers")


def _panel(panel: int) -> dict[str, Any]:
    return {} if panel == 0 else {"xaxis": "x2", "yaxis": "y2"}


def _two_panels(left: tuple[str, str], right: tuple[str, str]) -> dict[str, Any]:
    axes: dict[str, Any] = {"hovermode": "closest"}
    for suffix, anchor, (across, up), domain in (
        ("", "", left, [0.0, 0.46]),
        ("2", "2", right, [0.56, 1.0]),
    ):
        axes[f"xaxis{suffix}"] = {
            "title": {"text": across},
            "domain": domain,
            "anchor": f"y{anchor}",
        }
        axes[f"yaxis{suffix}"] = {
            "title": {"text": up},
            "anchor": f"x{anchor}",
            "scaleanchor": f"x{anchor}",
        }
    return axes
