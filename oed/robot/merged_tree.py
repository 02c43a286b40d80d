"""The tree of active joints that is left when fixed and locked parts are merged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint as DrakeJoint
from pydrake.multibody.tree import RevoluteJoint, RigidBody, WeldJoint

from oed.errors import RobotError
from oed.robot.inertia import transform_parameters
from oed.robot.robot import Joint
from oed.robot.robot_file import bodies_of, is_movable, joints_of

# Rotation entries this close to 0 or 1 are rounding of the file's roll, pitch and yaw.
ROUNDING = 1e-14


class MergedTree:
    """The active joints and, for each, the merged inertia of all that it carries.

    Attributes:
        joints: The active joints, in the order of their names.
        parameters: (10 n,) merged inertial parameters.
        carried: Names of the links that an active joint moves.
    """

    def __init__(
        self, plant: MultibodyPlant, names: Sequence[str], held: Mapping[str, float]
    ) -> None:
        self._plant = plant
        self._context = plant.CreateDefaultContext()
        for name, position in held.items():
            joint = plant.GetJointByName(name)
            (joint.set_angle if isinstance(joint, RevoluteJoint) else joint.set_translation)(
                self._context, position
            )
        self._column = {name: i for i, name in enumerate(names)}
        # Per body: the active joint that carries it and the body's pose in that joint's frame.
        self._carrier: dict[int, tuple[int, RigidTransform]] = {
            int(plant.world_body().index()): (-1, RigidTransform())
        }
        found: dict[int, Joint] = {}
        pending = joints_of(plant)
        while pending:
            ready = [j for j in pending if int(j.parent_body().index()) in self._carrier]
            if not ready:
                raise RobotError(f"joints {[j.name() for j in pending]} hang from no base")
            for joint in ready:
                self._place(joint, found)
            pending = [j for j in pending if j not in ready]
        self.carried = frozenset(
            body.name() for body in bodies_of(plant) if self._carrier[int(body.index())][0] >= 0
        )
        self.joints = tuple(found[i] for i in range(len(names)))
        self.parameters = self._merge_inertia(len(names))

    def carrier(self, body: str) -> int:
        """Column of the active joint that carries a body; -1 of one that stands still.

        Raises:
            RobotError: If there is no such body.
        """
        if body in ("", "world"):
            return -1
        if not self._plant.HasBodyNamed(body):
            raise RobotError(f"there is no body {body!r}")
        return self._carrier[int(self._plant.GetBodyByName(body).index())][0]

    def pose(self, body: RigidBody) -> tuple[int, RigidTransform]:
        """Column of the active joint that carries a body, -1 for none, and its pose in that frame."""
        return self._carrier[int(body.index())]

    def _place(self, joint: DrakeJoint, found: dict[int, Joint]) -> None:
        parent, X_CP = self._carrier[int(joint.parent_body().index())]
        X_CF = X_CP @ joint.frame_on_parent().GetFixedPoseInBodyFrame()
        X_BM = joint.frame_on_child().GetFixedPoseInBodyFrame()
        child = int(joint.child_body().index())
        column = self._column.get(joint.name())
        if column is None or not is_movable(joint):
            X_FM = self._held_pose(joint)
            self._carrier[child] = (parent, X_CF @ X_FM @ X_BM.inverse())
            return
        is_revolute = isinstance(joint, RevoluteJoint)
        axis = joint.revolute_axis() if is_revolute else joint.translation_axis()
        found[column] = Joint(
            name=joint.name(),
            kind="revolute" if is_revolute else "prismatic",
            parent=parent,
            axis=_without_rounding(np.asarray(axis)),
            R_PJ=_without_rounding(np.asarray(X_CF.rotation().matrix())),
            p_PJ=np.asarray(X_CF.translation()),
            link=joint.child_body().name(),
            R_LJ=np.asarray(X_BM.rotation().matrix()),
            p_LJ=np.asarray(X_BM.translation()),
        )
        self._carrier[child] = (column, X_BM.inverse())

    def _held_pose(self, joint: DrakeJoint) -> RigidTransform:
        if isinstance(joint, WeldJoint):
            return joint.X_FM()
        return joint.frame_on_child().CalcPose(self._context, joint.frame_on_parent())

    def _merge_inertia(self, joints: int) -> np.ndarray:
        parameters = np.zeros((joints, 10))
        for body in bodies_of(self._plant):
            carrier, X_CB = self._carrier[int(body.index())]
            if carrier >= 0:
                rotation, origin = X_CB.rotation().matrix(), X_CB.translation()
                parameters[carrier] += transform_parameters(
                    _body_parameters(body), np.asarray(rotation), np.asarray(origin)
                )
        return parameters.reshape(-1)


def _body_parameters(body: RigidBody) -> np.ndarray:
    spatial = body.default_spatial_inertia()
    mass = spatial.get_mass()
    if not np.isfinite(mass) or mass == 0.0:
        return np.zeros(10)
    inertia = spatial.CalcRotationalInertia()
    moments, products = inertia.get_moments(), inertia.get_products()
    xx, yy, zz = moments
    xy, xz, yz = products
    return np.array([mass, *(mass * np.asarray(spatial.get_com())), xx, xy, xz, yy, yz, zz])


def _without_rounding(entries: np.ndarray) -> np.ndarray:
    """Make entries within rounding of 0 and +-1 exact, so that products with them vanish."""
    nearest = np.round(entries)
    return np.where(np.abs(entries - nearest) < ROUNDING, nearest, entries)
