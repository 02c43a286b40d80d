"""The paper's laboratory, rebuilt: the IMI arm with a truth that is known (section 4)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import Effect, Viscous
from oed.dynamics.effects.nonlinear_viscous import NonlinearViscous
from oed.dynamics.effects.position import TorqueRipple
from oed.experiment.control import Controller, JointLoad, Specification, design_gains
from oed.experiment.disturbance import Disturbance
from oed.experiment.friction_memory import BristleFriction
from oed.experiment.observer import HighGainObserver
from oed.experiment.plant import TruePlant
from oed.experiment.sensors import Sensors
from oed.experiment.simulation import Setup
from oed.robot.builtin import IMI_BASE_PARAMETERS, IMI_COULOMB, IMI_VISCOUS, imi_scara

Friction = Literal["plain", "rich"]


@dataclass(frozen=True)
class ImiLaboratory:
    """Every choice that the paper leaves open, with the value used here.

    Attributes:
        resolver_bits: Resolver-to-digital conversion, bits a turn.
        specification: Of the closed loop; the paper states it but not the gains.
        disturbance_corner: Colour of the torque disturbance [rad/s]. The paper's residuals (1.34
            and 0.24 N m) are smaller than the standard deviations that it measured (1.75 and
            0.40 N m): its noise must reach beyond its filter (14 rad/s).
        presliding: Bending of the friction's bristles before they slip [rad]; as good as none.
        stribeck_rise: Rich friction: rise of friction towards standstill, of F_c.
        stribeck_speed: Rich friction: speed scale of that rise [rad/s].
        rich_presliding: Rich friction: bending before slip [rad].
        thinning: Rich friction: share of viscous friction that thins with speed.
        thinning_speed: Rich friction: speed at which that share has halved [rad/s].
        ripple: Rich friction: torque ripple of the direct-drive motors, of F_c.
        poles: Rich friction: ripple periods a turn.
        settling: Time from rest into a run, and out of it to rest [s].
    """

    resolver_bits: int = 16
    specification: Specification = field(default_factory=Specification)
    disturbance_corner: tuple[float, float] = (30.0, 30.0)
    presliding: float = 2e-5
    stribeck_rise: float = 0.3
    stribeck_speed: float = 0.1
    rich_presliding: float = 0.005
    thinning: float = 0.3
    thinning_speed: float = 1.0
    ripple: float = 0.1
    poles: int = 8
    settling: float = 1.0

    def truth(self) -> Float[ndarray, "8"]:
        """Xi of the paper's model: the J_k column of its table of estimates."""
        friction = [x for pair in zip(IMI_COULOMB, IMI_VISCOUS, strict=True) for x in pair]
        return np.array([*IMI_BASE_PARAMETERS, *friction])

    def plant(self, friction: Friction) -> TruePlant:
        """The arm: "plain" has the paper's friction (15), "rich" what its authors suspected."""
        is_rich = friction == "rich"
        bristles = tuple(
            BristleFriction(
                joint,
                coulomb,
                deflection=self.rich_presliding if is_rich else self.presliding,
                static_rise=self.stribeck_rise * coulomb if is_rich else 0.0,
                stribeck_speed=self.stribeck_speed,
            )
            for joint, coulomb in enumerate(IMI_COULOMB)
        )
        effects: list[Effect] = []
        sizes: list[float] = []
        for joint, (coulomb, viscous) in enumerate(zip(IMI_COULOMB, IMI_VISCOUS, strict=True)):
            effects.append(Viscous(joint))
            sizes.append(viscous * (1 - self.thinning) if is_rich else viscous)
            if is_rich:
                effects.append(NonlinearViscous(joint, thinning=1 / self.thinning_speed))
                sizes.append(viscous * self.thinning)
                effects.append(TorqueRipple(joint, (float(self.poles),)))
                sizes += [0.0, self.ripple * coulomb]
        return TruePlant(imi_scara(), tuple(effects), tuple(sizes), bristles)

    def loads(self) -> tuple[JointLoad, JointLoad]:
        """What each joint's loop sees, from the truth: diagonal of the mass matrix."""
        plant = self.plant("plain")
        lower, upper = plant.robot.limits.position[1]
        elbow = np.linspace(lower, upper, 61)
        positions = np.stack([np.zeros_like(elbow), elbow], axis=1)
        diagonals = np.diagonal(plant.mass_matrix(positions), axis1=1, axis2=2)
        first, second = (
            JointLoad(float(d.mean()), (float(d.min()), float(d.max())), viscous)
            for d, viscous in zip(diagonals.T, IMI_VISCOUS, strict=True)
        )
        return first, second

    def controller(self) -> Controller:
        """Gains by `design_gains` for the paper's specification and observer."""
        return design_gains(self.loads(), HighGainObserver.paper(), self.specification)

    def quiet(self, std: tuple[float, float] = (1.0, 0.3)) -> Disturbance:
        """A disturbance of the laboratory's colour."""
        return Disturbance(std, self.disturbance_corner)

    def setup(self, friction: Friction, controller: Controller, disturbance: Disturbance) -> Setup:
        """The whole laboratory."""
        sensors = Sensors.resolvers(2, self.resolver_bits)
        # One step a period: 3 mN m rms from eight of them, a thousandth of the disturbance.
        return Setup(
            self.plant(friction),
            controller,
            sensors,
            disturbance,
            lead_in=self.settling,
            lead_out=self.settling,
            substeps=1,
        )
