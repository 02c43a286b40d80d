"""What a log holds, to look into: where the joints went, positions and torques as they were logged."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.experiment.dataset import DataSet
from oed.experiment.recording import ROLES, Recording, Role
from oed.report.chart import (
    BOTTOM,
    TOP,
    Chart,
    Trace,
    line,
    panel_axis,
    plain,
    points_for,
    stacked_panels,
)
from oed.report.colours import BLUE, GREY, ORANGE, PURPLE

COLOURS: dict[Role, str] = dict(zip(ROLES, (BLUE, ORANGE, PURPLE), strict=True))
BAR = 16  # [px] of a role at a joint
JOINT = 14  # [px] between joints
LIMITS = "limits"


def range_chart(dataset: DataSet) -> Chart:
    """A bar for each role and joint, from the lowest to the highest position; grey: the limits."""
    joints = dataset.robot.joints
    names = [plain(joint.name) for joint in joints]
    units = [joint.unit("rad") for joint in joints]
    roles = _roles(dataset)
    limits = dataset.robot.limits.position
    known = [j for j in range(len(joints)) if np.isfinite(limits[j]).all()]
    # The limits are the first of the bars that lie side by side at a joint.
    traces = [
        _bars(
            [names[j] for j in known], limits[known], [units[j] for j in known],
            name=LIMITS, colour=GREY,
        )
    ] if known else []  # fmt: skip
    for role in roles:
        q = np.concatenate([r.q for r in dataset.recordings if r.role == role])
        ends = np.column_stack([q.min(axis=0), q.max(axis=0)])
        traces.append(_bars(names, ends, units, name=role, colour=COLOURS[role]))
    slides = any(joint.kind == "prismatic" for joint in joints)
    axes = {
        "xaxis": {
            "title": {"text": "position [rad; m of a slide]" if slides else "position [rad]"}
        },
        "yaxis": {"autorange": "reversed", "type": "category"},
        "barmode": "group",
        "bargap": JOINT / (JOINT + BAR * len(traces)),
        "margin": {"l": 8, "r": 8, "t": TOP, "b": BOTTOM},
    }
    height = TOP + BOTTOM + (JOINT + BAR * len(traces)) * len(joints)
    caption = "Positions of each joint by role, beside the limits of the robot's file."
    return Chart(traces, axes, caption, height)


def _bars(
    names: Sequence[str],
    ends: Float[ndarray, "joints 2"],
    units: Sequence[str],
    *,
    name: str,
    colour: str,
) -> Trace:
    told = [
        f"{low:.4g} to {high:.4g} {unit}" for (low, high), unit in zip(ends, units, strict=True)
    ]
    return {
        "type": "bar", "orientation": "h", "name": name, "y": list(names), "base": ends[:, 0],
        "x": ends[:, 1] - ends[:, 0], "marker": {"color": colour}, "customdata": told,
        "hovertemplate": "%{y}: %{customdata}",
    }  # fmt: skip


def signal_charts(dataset: DataSet) -> list[Chart]:
    """Positions, then torques, of every recording as it was logged, joint by joint."""
    joints = dataset.robot.joints
    points = points_for(2 * len(joints) * len(dataset.recordings))
    charts = []
    for what, rotary, key in (("Position", "rad", "q"), ("Torque", "N m", "tau")):
        units = [joint.unit(rotary) for joint in joints]
        traces: list[Trace] = []
        told: set[Role] = set()
        for recording in dataset.recordings:
            traces += _lines(recording, key, units, points, is_first=recording.role not in told)
            told.add(recording.role)
        titles = [f"{j.name} [{unit}]" for j, unit in zip(joints, units, strict=True)]
        axes, height = stacked_panels(titles, "time since each recording began [s]")
        charts.append(Chart(traces, axes, f"{what} of each joint, as logged.", height))
    return charts


def _lines(
    recording: Recording, key: str, units: Sequence[str], points: int, *, is_first: bool
) -> list[Trace]:
    values = recording.q if key == "q" else recording.tau
    since = recording.t - recording.t[0]
    return [
        line(
            since, values[:, j], points,
            name=recording.role, legendgroup=recording.role, showlegend=is_first and j == 0,
            yaxis=panel_axis(j), line={"color": COLOURS[recording.role], "width": 1.0},
            hovertemplate=f"%{{y:.4g}} {unit} at %{{x:.3f}} s, {plain(recording.name)}<extra></extra>",
        )
        for j, unit in enumerate(units)
    ]  # fmt: skip


def _roles(dataset: DataSet) -> list[Role]:
    return [role for role in ROLES if any(r.role == role for r in dataset.recordings)]
