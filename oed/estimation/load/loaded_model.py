"""The torque of an arm that holds a load, with friction that grows with what the gears carry.

    tau_j = (H beta)_j + (L phi)_j + mu_j |r_j| s_j,      r = H_rigid beta_rigid + L phi,

beta the arm's base parameters, phi the load's own (Khalil, Gautier and Lemoine 2007, "Identification
of the payload inertial parameters of industrial manipulators"), s_j the sign of the velocity
(Gogoussis and Donath 1988; Hamon, Gautier and Garrec 2010). Without the last term friction that the
load itself causes passes for mass.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.base_parameters import BaseParameters, find_base_parameters
from oed.dynamics.effects import Coulomb, State, TorqueOffset, Viscous
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.effects.stribeck import Stribeck
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion, random_motion
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.sign_width import choose_sign_widths
from oed.experiment.preparation.processed import ProcessedRecording
from oed.robot import JointLimits
from oed.robot.attached_frame import AttachedFrame
from oed.robot.inertia import PARAMETER_SYMBOLS

ENTRIES = len(PARAMETER_SYMBOLS)
# States at which the load's columns are compared: a few equations for each of ten columns.
STATES = 60


@dataclass(frozen=True)
class LoadedModel:
    """A torque model of an arm and of what it holds; x = (beta, phi, mu).

    Attributes:
        arm: The torque model without a load.
        base: Its base parameters beta.
        frame: Where the load is held.
        kept: Which of the load's ten parameters, about its joint's body frame, are phi; the rest
            makes no torque of its own. None at all for the bare arm.
        has_load_friction: Whether mu is part of the model.
    """

    arm: TorqueModel
    base: BaseParameters
    frame: AttachedFrame
    kept: tuple[int, ...]
    has_load_friction: bool = True

    @classmethod
    def bare(
        cls, arm: TorqueModel, frame: AttachedFrame, *, has_load_friction: bool = True
    ) -> LoadedModel:
        """The arm that holds nothing."""
        return cls(arm, base_parameters(arm), frame, (), has_load_friction)

    def turning_as(self, recordings: Sequence[ProcessedRecording]) -> LoadedModel:
        """The same with friction that turns its sign over the velocities that recordings tell."""
        arm = choose_sign_widths(self.arm, self.base.columns, recordings)
        return dataclasses.replace(self, arm=arm)

    def loaded(self) -> LoadedModel:
        """The same arm with a load whose parameters make torque of their own."""
        robot = self.arm.robot.with_limits(JointLimits.unlimited(self.arm.robot.n))
        motion = random_motion(robot, STATES, np.random.default_rng(0))
        load = self._load()
        columns = TorqueModel(self.arm.robot, (load,)).regressor(motion)
        found = find_base_parameters(columns, load.parameters)
        kept = tuple(sorted(int(c) for c in found.columns))
        return LoadedModel(self.arm, self.base, self.frame, kept, self.has_load_friction)

    @property
    def names(self) -> tuple[str, ...]:
        """Of x."""
        load = tuple(f"load_{PARAMETER_SYMBOLS[k]}" for k in self.kept)
        return (*self.base.names, *load, *self._friction_names)

    @property
    def load(self) -> slice:
        """Where phi stands in x."""
        return slice(len(self.base), len(self.base) + len(self.kept))

    @property
    def load_friction(self) -> slice:
        """Where mu stands in x."""
        return slice(self.load.stop, len(self.names))

    @cached_property
    def is_friction(self) -> Bool[ndarray, " x"]:
        """Which of x change from day to day: friction over speed, and what a torque is off at rest."""
        changing = np.zeros(len(self.names), dtype=bool)
        owners = [e for e in self.arm.effects for _ in e.parameters]
        for k, column in enumerate(self.base.columns):
            changing[k] = isinstance(owners[column], Coulomb | Viscous | Stribeck | TorqueOffset)
        return changing

    def raw_columns(self, motion: Motion) -> Float[ndarray, "samples joints columns"]:
        """H and L side by side: what is linear in beta and phi."""
        arm = self.base.reduce(self.arm.columns(motion))
        if not self.kept:
            return arm
        held = TorqueModel(self.arm.robot, (self._load(),), self.arm.measurement)
        return np.concatenate([arm, held.columns(motion)[:, :, list(self.kept)]], axis=2)

    def signs(self, motion: Motion) -> Float[ndarray, "samples joints"]:
        """s_j, turning as the model's own Coulomb friction does."""
        state = State.along(motion)
        widths = {e.joint: e.width for e in self.arm.effects if isinstance(e, Coulomb)}
        return np.column_stack(
            [state.sign(dq, widths.get(j, 0.0)) for j, dq in enumerate(state.dq)]
        )

    @property
    def is_rigid(self) -> Bool[ndarray, " columns"]:
        """Which columns of H and L press on the gears: those of bodies."""
        of_bodies = self.base.columns < ENTRIES * self.arm.robot.n  # the first effect's
        return np.append(of_bodies, np.ones(len(self.kept), dtype=bool))

    @property
    def _friction_names(self) -> tuple[str, ...]:
        joints = range(1, self.arm.robot.n + 1) if self.has_load_friction else ()
        return tuple(f"mu_{j}" for j in joints)

    def _load(self) -> PayloadChange:
        return PayloadChange(self.arm.robot, self.frame.joint, -np.inf, start=0.0)
