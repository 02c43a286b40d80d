"""What the robot's file says of the parameters that were estimated, and of the total mass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy import stats

from oed.dynamics.effects import with_columns
from oed.dynamics.effects.rigid_body import RigidBody
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.calibration import Calibration
from oed.robot.inertia import PARAMETER_UNITS

# Share of a combination that may lie outside what base parameters tell: rounding of the regrouping.
ROUNDING = 1e-6


@dataclass(frozen=True)
class TotalMass:
    """The mass of all links that move.

    Attributes:
        file: In the robot's file [kg].
        is_in_torque: Whether torques of this arm depend on it, so that recordings can tell it.
        value: As identified [kg]; None where these recordings do not determine it.
        interval: 95 % [kg]; None likewise.
    """

    file: float
    is_in_torque: bool
    value: float | None
    interval: tuple[float, float] | None


def file_values(calibration: Calibration) -> Float[ndarray, " estimated"]:
    """The file's value of each estimated parameter: the same combination of its links' inertials.

    NaN where a combination holds what no robot file says, such as friction; where the estimate is of
    another combination, because the data determine only that; and where currents stand for torques.
    """
    base, estimate = calibration.base, calibration.estimate
    stated = _stated(calibration.model)
    values = base.from_standard(np.nan_to_num(stated))
    is_stated = ~((base.regrouping != 0) & np.isnan(stated)).any(axis=1)
    return np.array(
        [
            values[c] if is_stated[c] and name == base.names[c] else np.nan
            for name, c in zip(estimate.names, estimate.columns, strict=True)
        ]
    )


def total_mass(calibration: Calibration) -> TotalMass:
    """The mass of all that moves, which base parameters tell of few arms.

    It is a combination of them where a slide carries everything, for example; an arm whose first
    joint turns moves its first link's mass about a fixed axis or not at all.
    """
    base, estimate = calibration.base, calibration.estimate
    robot = calibration.model.robot
    masses = np.zeros(base.regrouping.shape[1])
    masses[_bodies(calibration.model)[::10]] = 1.0
    weights = np.linalg.lstsq(base.regrouping.T, masses, rcond=None)[0]
    outside = np.linalg.norm(masses - weights @ base.regrouping)
    told = bool(outside <= ROUNDING * np.linalg.norm(masses))
    file = float(robot.parameters[::10].sum())
    own = np.zeros(len(estimate.names))
    known = [
        k
        for k, (name, c) in enumerate(zip(estimate.names, estimate.columns, strict=True))
        if name == base.names[c] and estimate.determined[k]
    ]
    own[known] = weights[[estimate.columns[k] for k in known]]
    is_whole = np.isclose(np.abs(own).sum(), np.abs(weights).sum())
    if not (told and is_whole) or any(joint.effort == "A" for joint in robot.joints):
        return TotalMass(file, told, None, None)
    value = float(own @ estimate.parameters)
    freedom = float(estimate.effective_degrees_of_freedom[own != 0].min())
    reach = float(stats.t.ppf(0.975, freedom) * np.sqrt(own @ estimate.covariance @ own))
    return TotalMass(file, told, value, (value - reach, value + reach))


def _stated(model: TorqueModel) -> Float[ndarray, " parameters"]:
    """The file's value of every column of the model; NaN where it says nothing."""
    stated = np.full(len(model.parameters), np.nan)
    bodies, units = _bodies(model), [p.unit for p in model.parameters]
    in_file = np.array([units[c] in PARAMETER_UNITS for c in bodies])
    stated[bodies[in_file]] = model.robot.parameters[in_file]
    return stated


def _bodies(model: TorqueModel) -> ndarray:
    """Columns of the links' ten parameters each."""
    return np.concatenate(
        [
            np.arange(place.start, place.stop)
            for effect, place in with_columns(model.effects)
            if isinstance(effect, RigidBody)
        ]
    )
