"""Torque and what is left of it, role by role, for one model or for several side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.report.chart import Chart, points_for
from oed.report.estimation_charts import residual_chart, torque_chart
from oed.report.joint_words import torque_units
from oed.robot import Robot


@dataclass(frozen=True)
class Rows:
    """Torque along recordings, as measured and as models have it.

    Attributes:
        t: (N,) time [s].
        measured: (N, n) [N m, N at prismatic joints]; NaN is a gap.
        predicted: (N, n) in the same unit, by the name of each model.
    """

    t: Float[ndarray, " rows"]
    measured: Float[ndarray, "rows joints"]
    predicted: Mapping[str, Float[ndarray, "rows joints"]]

    @classmethod
    def end_to_end(cls, recordings: Sequence[Rows]) -> Rows:
        """Recordings of one or more rows set one after another, with a gap between."""
        times: list[ndarray] = []
        start = 0.0
        for recording in recordings:
            times.append(recording.t - recording.t[0] + start)
            step = float(np.diff(recording.t[:2]).sum())
            start = times[-1][-1] + step
        ends = np.cumsum([len(recording.t) for recording in recordings])[:-1]

        def joined(pieces: Sequence[ndarray]) -> ndarray:
            return np.insert(np.concatenate(pieces), ends, np.nan, axis=0)

        return cls(
            joined(times),
            joined([recording.measured for recording in recordings]),
            {
                name: joined([recording.predicted[name] for recording in recordings])
                for name in recordings[0].predicted
            },
        )


@dataclass(frozen=True)
class RoleTorques:
    """The recordings of one role.

    Attributes:
        role: Of the recordings.
        rows: Of all of them, end to end.
        rms: (n,) of what each model leaves, as the page's table has it, by its name.
        band: (n,) half the width of the band that is drawn about zero: what a residual is compared with.
    """

    role: str
    rows: Rows
    rms: Mapping[str, Float[ndarray, " joints"]]
    band: Float[ndarray, " joints"]


def torque_charts(robot: Robot, roles: Sequence[RoleTorques], *, band: str) -> list[Chart]:
    """Two charts a role: torque and residual, joint by joint.

    Args:
        robot: Whose joints they are.
        roles: With recordings.
        band: What the lines about zero are, such as "± rms".
    """
    joints, units = robot.joint_names, torque_units(robot.joints)
    lines = sum(robot.n * (1 + 2 * len(told.rms)) for told in roles)
    points = points_for(lines)
    charts = []
    for told in roles:
        rows, where = told.rows, f"recordings with role {told.role}"
        left = {name: rows.measured - tau for name, tau in rows.predicted.items()}
        charts += [
            torque_chart(
                rows.t, rows.measured, rows.predicted, joints, units, points=points,
                caption=f"Measured and reconstructed torque, {where}.",
            ),
            residual_chart(
                rows.t, left, told.rms, joints, units, band=told.band, points=points,
                caption=f"Measured minus reconstructed torque, {where}; the lines are at {band}.",
            ),
        ]  # fmt: skip
    return charts
