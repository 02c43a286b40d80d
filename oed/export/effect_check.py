"""Whether effects that a file describes are effects of its robot: each is evaluated once."""

from __future__ import annotations

import numpy as np

from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.export.model_record import ModelFileError

INSTANTS, STEP = 8, 0.01  # [1], [s] of a motion that every effect can be evaluated on


def check_effects(model: TorqueModel) -> None:
    """Refuse joints that the robot does not have, and values that are nothing of that kind.

    Raises:
        ModelFileError: Naming the effect.
    """
    t = STEP * np.arange(INSTANTS)
    q, dq, ddq = (np.tile(x[:, None], model.robot.n) for x in (np.sin(t), np.cos(t), -np.sin(t)))
    motion = Motion(t, q, dq, ddq)
    body = model.effects[:1]
    alone = {f"effects[{k}]": ((e,), ()) for k, e in enumerate(model.effects)}
    alone |= {f"measurement[{k}]": (body, (m,)) for k, m in enumerate(model.measurement)}
    for place, (effects, measurement) in alone.items():
        try:
            own = TorqueModel(model.robot, effects, measurement)
            own.torque(np.ones(len(own.parameters)), motion)
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            name = (measurement or effects)[0].name
            raise ModelFileError(f"{place}: {name} cannot be evaluated: {error}") from error
