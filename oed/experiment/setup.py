"""A virtual laboratory: everything that stays the same from one experiment to the next."""

from __future__ import annotations

from dataclasses import dataclass, field

from oed.experiment.control import Controller
from oed.experiment.disturbance import Disturbance
from oed.experiment.plant import TruePlant
from oed.experiment.sensors import Sensors


@dataclass(frozen=True)
class Setup:
    """A laboratory: everything that stays the same from one experiment to the next.

    Attributes:
        plant: The machine as it really is.
        controller: Sampled feedback; its period is the sampling period of the recording.
        sensors: Encoder, torque signal and what is logged.
        disturbance: Random torque at the joints; None is none.
        lead_in: Time from rest to the start of the trajectory [s].
        lead_out: Time from the end of the trajectory to rest [s]; 0 to stop the log there.
        substeps: Integration steps of the plant in one control period.
    """

    plant: TruePlant
    controller: Controller
    sensors: Sensors = field(default_factory=Sensors)
    disturbance: Disturbance | None = None
    lead_in: float = 1.5
    lead_out: float = 0.0
    substeps: int = 2

    def __post_init__(self) -> None:
        if self.controller.n != self.plant.robot.n:
            raise ValueError(
                f"controller of {self.controller.n} joints, robot of {self.plant.robot.n}"
            )
        if self.lead_in <= 0 or self.substeps < 1:
            raise ValueError(f"lead-in {self.lead_in} s, {self.substeps} substeps: too small")
