"""A fixed-base tree of revolute and prismatic joints, one body a joint."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.errors import NoUsableResult
from oed.robot.description import RobotDescription
from oed.robot.inertia import PARAMETER_SYMBOLS, PARAMETER_UNITS
from oed.robot.limits import LIMITED, JointLimits
from oed.robot.possible_inertia import InertiaFault

# Of the ten parameters of a link, where a current stands for torque: kg m^2 are N m s^2.
CURRENT_UNITS = ("A s^2/m^2", *("A s^2/m",) * 3, *("A s^2",) * 6)
CONSTANTS = "current_to_torque: N m (N at a slide) at the joint per A of the motor, gear included"
# Radius at which a turning drive's velocity is that of a slide: pinions, pulleys and the leads of
# fast screws lie within a factor of a few.
PINION_RADIUS = 0.05  # [m]
# What unit vectors and rotations written with seven digits are off by at most.
ROUNDED = 1e-6


@dataclass(frozen=True)
class Joint:
    """A joint and the body that it carries; fixed parts are merged into that body.

    The body frame J sits on the joint axis and turns with the body. L is the frame
    of the link in the file that the robot came from.

    Attributes:
        name: The joint's name in the file.
        kind: "revolute" or "prismatic".
        parent: Index of the joint whose body carries this one, -1 for the base.
        axis: Unit vector of the joint axis in J.
        R_PJ: Axes of J in the parent body frame at q = 0.
        p_PJ: Origin of J in the parent body frame at q = 0 [m].
        link: The link's name in the file.
        R_LJ: Axes of J in the link frame.
        p_LJ: Origin of J in the link frame [m].
        effort: What stands for its torque or force: "N m" (N of a prismatic joint), or "A" where a
            current does that no constant makes a torque of.
    """

    name: str
    kind: Literal["revolute", "prismatic"]
    parent: int
    axis: Float[ndarray, "3"]
    R_PJ: Float[ndarray, "3 3"]
    p_PJ: Float[ndarray, "3"]
    link: str
    R_LJ: Float[ndarray, "3 3"]
    p_LJ: Float[ndarray, "3"]
    effort: Literal["N m", "A"] = "N m"

    def __post_init__(self) -> None:
        length = np.linalg.norm(self.axis)
        if not abs(length - 1) < ROUNDED:
            raise ValueError(f"joint {self.name}: its axis has length {length:.4g}, not 1")
        for name, R in (("R_PJ", self.R_PJ), ("R_LJ", self.R_LJ)):
            if not (np.abs(R @ R.T - np.eye(3)).max() < ROUNDED and np.linalg.det(R) > 0):
                raise ValueError(f"joint {self.name}: its {name} is no rotation")

    def unit(self, rotary: str) -> str:
        """The unit at this joint of what has the unit `rotary` at a revolute one.

        "N m s/rad" is "N s/m" at a prismatic joint, and "A s/rad" of a current.
        """
        if self.effort == "A":
            of_current = rotary.replace("N m", "A").replace("kg m^2", "A s^2/rad")
            return of_current if self.kind == "revolute" else of_current.replace("rad", "m")
        if self.kind == "revolute":
            return rotary
        return rotary.replace("N m", "N").replace("kg m^2", "kg").replace("rad", "m")

    def speed(self, rotary: float) -> float:
        """The velocity at this joint that compares with `rotary` [rad/s] at a revolute one.

        That of the rim of a pinion of `PINION_RADIUS` at a prismatic joint [m/s].
        """
        return rotary if self.kind == "revolute" else PINION_RADIUS * rotary


@dataclass(frozen=True)
class Robot:
    """A robot as the dynamics see it.

    Attributes:
        name: For reports.
        joints: The n active joints in the order of every (N, n) array.
        parameters: (10 n,) standard inertial parameters, joint by joint, each about
            its body frame's origin; in the order of `oed.robot.inertia`.
        gravity: (3,) acceleration of gravity in the base frame [m/s^2].
        limits: Limits of the n joints.
        source: File or built-in name that the robot was loaded from.
        locked: Names of the joints of the source that are held still.
        locked_at: Where each of them is held [rad or m]; all at 0 if empty.
        inertia_faults: Of moving links in the source; `parameters` hold others in their place.
        description: The file as it was read, for other programs; None of a built-in robot.
        notes: What was replaced, fixed or assumed when the file was read, for the user.
    """

    name: str
    joints: tuple[Joint, ...]
    parameters: Float[ndarray, " standard"]
    gravity: Float[ndarray, "3"]
    limits: JointLimits
    source: str = ""
    locked: tuple[str, ...] = ()
    locked_at: tuple[float, ...] = ()
    inertia_faults: tuple[InertiaFault, ...] = ()
    description: RobotDescription | None = field(default=None, repr=False)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if len(self.parameters) != 10 * self.n:
            raise ValueError(f"{len(self.parameters)} parameters for {self.n} joints of ten each")
        for kind in LIMITED:
            if (given := len(getattr(self.limits, kind))) != self.n:
                raise ValueError(f"{kind} limits of {given} joints, robot has {self.n}")
        names = self.joint_names
        for name in names:
            if not name.strip() or not name.isprintable():
                raise ValueError(f"a joint is called {name!r}: give it a name in letters")
        if twice := [name for name in dict.fromkeys(names) if names.count(name) > 1]:
            raise ValueError(f"two joints are called {twice[0]!r}")
        self._check_tree()

    def _check_tree(self) -> None:
        """Refuse joints from which no way leads to the base."""
        for start, joint in enumerate(self.joints):
            at, steps = start, 0
            while at != -1:
                if not 0 <= at < self.n or steps > self.n:
                    raise ValueError(
                        f"joint {joint.name}: no way leads from it to the base, whose index is -1"
                    )
                at, steps = self.joints[at].parent, steps + 1

    @property
    def n(self) -> int:
        """Number of active joints."""
        return len(self.joints)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the active joints, in column order."""
        return tuple(joint.name for joint in self.joints)

    @cached_property
    def outward(self) -> tuple[int, ...]:
        """Joint indices ordered so that every parent precedes its children."""
        order: list[int] = []
        while len(order) < self.n:
            order += [
                i
                for i, joint in enumerate(self.joints)
                if i not in order and (joint.parent == -1 or joint.parent in order)
            ]
        return tuple(order)

    @property
    def held(self) -> dict[str, float]:
        """Where each joint of the source that is not active is held, by name [rad or m]."""
        return dict(zip(self.locked, self.locked_at or (0.0,) * len(self.locked), strict=True))

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """(10 n) names such as "mx_2": symbol and joint number from 1."""
        return tuple(f"{s}_{i + 1}" for i in range(self.n) for s in PARAMETER_SYMBOLS)

    @property
    def parameter_units(self) -> tuple[str, ...]:
        """(10 n) units of `parameters`."""
        units = CURRENT_UNITS if self.in_amperes else PARAMETER_UNITS
        return units * self.n

    @property
    def in_amperes(self) -> bool:
        """Whether what stands for torque are currents, so that no parameter is in kg."""
        return any(joint.effort == "A" for joint in self.joints)

    def require_newton_metres(self, whose: str) -> None:
        """Refuse currents where bodies are asked for.

        Args:
            whose: Currents these are, for the message.

        Raises:
            NoUsableResult: In one line that says what to do.
        """
        if self.in_amperes:
            raise NoUsableResult(
                f"{whose}: currents in amperes tell no kilograms, so that no URDF, SDF or MJCF is made of "
                f"them; state {CONSTANTS}, in [drive] of dataset.toml, or find it with a known load: oed "
                "gains"
            )

    def with_amperes(self) -> Robot:
        """This robot with currents in place of torques."""
        joints = tuple(dataclasses.replace(joint, effort="A") for joint in self.joints)
        return dataclasses.replace(self, joints=joints)

    def with_parameters(self, parameters: Float[ndarray, " standard"]) -> Robot:
        """This robot with other inertial parameters."""
        return dataclasses.replace(self, parameters=np.asarray(parameters, dtype=float))

    def with_gravity(self, gravity: Float[ndarray, "3"]) -> Robot:
        """This robot under another gravity [m/s^2]."""
        return dataclasses.replace(self, gravity=np.asarray(gravity, dtype=float))

    def with_packages(self, packages: Mapping[str, Path]) -> Robot:
        """This robot with folders named in which its file's ROS packages lie."""
        if self.description is None or not packages:
            return self
        described = dataclasses.replace(self.description, packages=dict(packages))
        return dataclasses.replace(self, description=described)

    def with_limits(self, limits: JointLimits) -> Robot:
        """This robot with other limits."""
        return dataclasses.replace(self, limits=limits)
