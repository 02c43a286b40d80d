"""What MJCF cannot say, as a passive force of MuJoCo."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from oed.export.effect_torque import SIGN_WIDTH, EffectTorque
from oed.export.model import Model
from oed.export.model_file import load_model

# An MJCF joint has the viscous friction and the rotor of the model. Its dry friction is left to
# this force: MuJoCo's own, `frictionloss`, is a constraint that turns otherwise.
NATIVE = ("damping", "armature")


class PassiveForce:
    """A callback for `mujoco.set_mjcb_passive`.

    Friction under load, and whatever else depends on the acceleration, has that of the step before.
    Memory goes on once a step: an integrator that evaluates more than once, RK4, is refused.
    """

    def __init__(
        self, model: Model, mjmodel: mujoco.MjModel, *, sign_width: float = SIGN_WIDTH
    ) -> None:
        """Prepare the force.

        Args:
            model: The torque model.
            mjmodel: Has its joints, by name.
            sign_width: Velocity over which signs turn at least [rad/s]; 0 for the model's own.

        Raises:
            ValueError: If a joint is missing, or the integrator is RK4 beside effects with a memory.
        """
        self._effects = EffectTorque.of(model, NATIVE, mjmodel.opt.timestep, sign_width=sign_width)
        rk4 = int(mujoco.mjtIntegrator.mjINT_RK4)
        if self._effects.keeps and mjmodel.opt.integrator == rk4:
            raise ValueError(
                'effects with a memory go on once a step: choose integrator="implicitfast", not RK4'
            )
        names = model.robot.joint_names
        ids = [mujoco.mj_name2id(mjmodel, mujoco.mjtObj.mjOBJ_JOINT, name) for name in names]
        missing = [name for name, i in zip(names, ids, strict=True) if i < 0]
        if missing:
            raise ValueError(f"the MJCF model has no joint {missing[0]!r}, which the model has")
        self._q, self._v = mjmodel.jnt_qposadr[ids], mjmodel.jnt_dofadr[ids]
        self._time = np.nan
        self._memory = self._next = np.zeros(0)

    def __call__(self, _mjmodel: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Take the effects' torque off the passive force."""
        q, dq, ddq = data.qpos[self._q], data.qvel[self._v], data.qacc[self._v]
        if data.time > self._time:
            self._memory = self._next
        elif data.time != self._time:  # the first call, or the simulation was set back
            self._memory = self._effects.begin(q, dq)
        self._time = data.time
        torque, self._next = self._effects.torque(q, dq, ddq, self._memory)
        data.qfrc_passive[self._v] -= torque


def passive_force(
    path: str | Path, mjmodel: mujoco.MjModel, *, sign_width: float = SIGN_WIDTH
) -> PassiveForce:
    """The callback of a model.json; arguments as of `PassiveForce`."""
    return PassiveForce(load_model(path), mjmodel, sign_width=sign_width)
