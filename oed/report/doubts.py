"""What of an identification cannot be right, in words: a joint at rest, negative friction, the like."""

from __future__ import annotations

import re

import numpy as np

from oed.estimation.calibration import Calibration

USELESS = 0.3  # rms residual over rms torque; measured arms reach a few per cent, wrists ten or so
# What is negative for no joint and no link; a sum with other parameters may be.
NEVER_NEGATIVE = {
    "Fc": "Coulomb friction",
    "Fv": "viscous friction",
    "Ia": "rotor inertia",
    "m": "mass",
}
CAUSES = (
    "likely causes: the sign or order of torque columns, gravity in dataset.toml, units, another "
    "robot's file, too short a recording, or an effect that the model lacks"
)


def doubts(calibration: Calibration) -> tuple[str, ...]:
    """A line for each joint that stood still or is predicted badly, and each impossible parameter."""
    return (
        *_still(calibration),
        *_badly_predicted(calibration),
        *_impossible(calibration),
    )


def _still(calibration: Calibration) -> list[str]:
    return [
        f"{joint}: moves by no more than {travel:.2g} rad or m in the estimation recordings: what is "
        "said of its friction and inertia is made of noise; record it moving, or choose the other "
        "joints with --joints"
        for joint, travel in calibration.dataset.still.items()
    ]


def _badly_predicted(calibration: Calibration) -> list[str]:
    """Judged on validation, or on estimation where nothing was kept for it."""
    role = "validation" if "validation" in calibration.validation else "estimation"
    relative = calibration.validation[role].relative_rms
    joints = calibration.dataset.robot.joint_names
    return [
        f"{joints[j]}: the residual on {role} is {100 * relative[j]:.3g} % of the torque; {CAUSES}"
        for j in np.flatnonzero(relative > USELESS)
    ]


def _impossible(calibration: Calibration) -> list[str]:
    """Only parameters that stand alone: regrouped with others, a negative sum is no fault."""
    estimate, found = calibration.estimate, []
    interval = estimate.interval(0.95)
    for k, name in enumerate(estimate.names):
        symbol = re.sub(r"_\d+$", "", name)
        is_alone = calibration.base.expressions[estimate.columns[k]] == name
        if not (estimate.determined[k] and is_alone and symbol in NEVER_NEGATIVE):
            continue
        if interval[k, 1] < 0:
            found.append(
                f"{name} = {estimate.parameters[k]:.4g} {estimate.units[k]}, its interval up to "
                f"{interval[k, 1]:.4g}: a {NEVER_NEGATIVE[symbol]} cannot be negative; {CAUSES}"
            )
    return found
