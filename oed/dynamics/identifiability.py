"""Which parameters of a model any motion can reveal: the base parameters of robot and model."""

from __future__ import annotations

import dataclasses
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.base_parameters import (
    RANK_TOLERANCE,
    BaseParameters,
    find_base_parameters,
    normalised_factor,
)
from oed.dynamics.effects import Parameter, RigidBody
from oed.dynamics.energy import energy_regressor
from oed.dynamics.motion import Motion, random_motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import JointLimits, Robot
from oed.robot.inertia import PARAMETER_SYMBOLS

# Rotations of a robot file are written with few digits. An entry this close to zero is taken
# for a right angle that was rounded (0.1 mrad; a machined right angle is known no better).
RIGHT_ANGLE = 1e-4
# Kept first within a link: inertia, then first moments, then mass. This is Gautier and
# Khalil's choice: masses are regrouped into the links before them.
WITHIN_LINK = (4, 5, 6, 7, 8, 9, 1, 2, 3, 0)
SAMPLES_PER_COLUMN = 4


def base_parameters(model: TorqueModel, *, seed: int = 0) -> BaseParameters:
    """Base parameters of a torque model, its effects regrouped with the rigid body's.

    The rank is decided on the robot with its rounded right angles made exact: rounding in a
    file can make one more combination visible, but only to a millionth of the torque.

    Args:
        model: Its measurement effects are ignored; they add no column.
        seed: Of the random motion.
    """
    rng = np.random.default_rng(seed)
    bare = dataclasses.replace(model, measurement=())
    joints = bare.robot.n
    samples = 20 + SAMPLES_PER_COLUMN * len(bare.parameters) // joints
    motion = random_motion(_unlimited(bare.robot), samples, rng)
    square = bare.with_robot(with_right_angles(bare.robot))
    return _reduce(
        given=bare.regressor(motion),
        square=square.regressor(motion),
        parameters=bare.parameters,
        robot=bare.robot,
    )


Route = Literal["torque", "energy"]


def rigid_body_base_parameters(robot: Robot, *, route: Route, seed: int = 0) -> BaseParameters:
    """Base inertial parameters alone, from the torque or from the energy model.

    A parameter matters to the energy model if its energy is not the same everywhere
    (Gautier and Khalil 1990): the regressor is the energy less its mean.
    """
    rng = np.random.default_rng(seed)
    samples = 20 + SAMPLES_PER_COLUMN * 10 * robot.n
    motion = random_motion(_unlimited(robot), samples, rng)
    evaluate = _centred_energy if route == "energy" else _torque
    return _reduce(
        given=evaluate(robot, motion),
        square=evaluate(with_right_angles(robot), motion),
        parameters=RigidBody(robot).parameters,
        robot=robot,
    )


def with_right_angles(robot: Robot) -> Robot:
    """The robot with rotation entries within 0.1 mrad of zero made zero.

    Each rotation is then brought back to the nearest orthonormal one.
    """
    joints = tuple(
        dataclasses.replace(joint, R_PJ=_nearest_rotation(joint.R_PJ)) for joint in robot.joints
    )
    return dataclasses.replace(robot, joints=joints)


def _reduce(
    given: Float[ndarray, "rows parameters"],
    square: Float[ndarray, "rows parameters"],
    parameters: tuple[Parameter, ...],
    robot: Robot,
) -> BaseParameters:
    lengths = sorted({round(float(abs(x)), 9) for joint in robot.joints for x in joint.p_PJ if x})
    exact = find_base_parameters(
        square, parameters, preference=_preference(parameters, robot), lengths=lengths
    )
    singular_values = np.linalg.svd(normalised_factor(given)[0], compute_uv=False)
    extra = int((singular_values > RANK_TOLERANCE * singular_values[0]).sum()) - len(exact)
    note = _rounding_note(given, exact, extra) if extra > 0 else ""
    return dataclasses.replace(exact, singular_values=singular_values, note=note)


def _rounding_note(
    given: Float[ndarray, "rows parameters"], exact: BaseParameters, extra: int
) -> str:
    missed = np.linalg.norm(given - exact.reduce(given) @ exact.regrouping, axis=0)
    typical = np.median(np.linalg.norm(exact.reduce(given), axis=0))
    rank = len(exact)
    return (
        f"As written, the file's kinematics have numerical rank {rank + extra}. The last {extra} "
        f"come from right angles that the file rounds: they carry at most "
        f"{missed.max() / typical:.0e} of a typical column's torque and vanish when the angles are "
        f"made exact. Rank {rank} is used."
    )


def _preference(parameters: tuple[Parameter, ...], robot: Robot) -> list[int]:
    """Columns by link from the base outward, within a link as `WITHIN_LINK`; effects last."""
    width = len(PARAMETER_SYMBOLS)
    inertial = [width * i + k for i in robot.outward for k in WITHIN_LINK]
    has_rigid_body = len(parameters) >= width * robot.n
    first = inertial if has_rigid_body else []
    return first + [c for c in range(len(parameters)) if c not in set(first)]


def _unlimited(robot: Robot) -> Robot:
    return robot.with_limits(JointLimits.unlimited(robot.n))


def _torque(robot: Robot, motion: Motion) -> Float[ndarray, "rows standard"]:
    return TorqueModel(robot, (RigidBody(robot),)).regressor(motion)


def _centred_energy(robot: Robot, motion: Motion) -> Float[ndarray, "rows standard"]:
    energy = energy_regressor(robot, motion)
    return energy - energy.mean(axis=0)


def _nearest_rotation(rotation: Float[ndarray, "3 3"]) -> Float[ndarray, "3 3"]:
    cleaned = np.where(np.abs(rotation) < RIGHT_ANGLE, 0.0, rotation)
    left, _, right = np.linalg.svd(cleaned)
    nearest = left @ right
    rounded = np.round(nearest)
    return np.where(np.abs(nearest - rounded) < 1e-14, rounded, nearest)
