"""What is known of the joints' drives, and how a torque was obtained."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from jaxtyping import Float
from numpy import ndarray

TorqueKind = Literal["measured", "current", "commanded"]
TORQUE_KINDS: tuple[TorqueKind, ...] = get_args(TorqueKind)


@dataclass(frozen=True)
class Drive:
    """What is known of the joints' drives, at the joint side; None where it is not.

    Attributes:
        gear_ratio: (n,) motor turns per joint turn.
        rotor_inertia: (n,) inertia of the rotor, at the motor side [kg m^2].
        current_to_torque: (n,) joint torque per motor current, gear included [N m/A]; the
            recordings' torques have been multiplied by it.

    Raises:
        ValueError: If the numbers of joints disagree or an entry is not finite.
    """

    gear_ratio: Float[ndarray, " joints"] | None = None
    rotor_inertia: Float[ndarray, " joints"] | None = None
    current_to_torque: Float[ndarray, " joints"] | None = None

    def __post_init__(self) -> None:
        given = {
            name: getattr(self, name) for name in DRIVE_KEYS if getattr(self, name) is not None
        }
        lengths = {name: len(values) for name, values in given.items()}
        if len(set(lengths.values())) > 1:
            raise ValueError(f"numbers of joints disagree: {lengths}")
        for name, values in given.items():
            if not np.isfinite(values).all():
                raise ValueError(f"{name} is not finite: {values}")


DRIVE_KEYS = ("gear_ratio", "rotor_inertia", "current_to_torque")
