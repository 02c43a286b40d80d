"""Friction of any shape over speed, for a model of which friction is not what is asked.

Undeclared friction at low speed, where joints turn round, is what keeps a load from being weighed better:
it is no noise, and does not average out in a short motion. Beside Coulomb and viscous friction stand terms
that die out at three shares of the top speed; together they follow any usual curve (Armstrong-Helouvry,
Dupont and Canudas de Wit 1994, section 2).
"""

from __future__ import annotations

import numpy as np

from oed.dynamics.effects import Coulomb
from oed.dynamics.effects.stribeck import Stribeck
from oed.dynamics.torque_model import TorqueModel

SHARES = (0.03, 0.1, 0.3)  # of the top speed: a decade in two steps of three
USUAL_SPEED = 2.0  # [rad/s] where a file states no limit


def with_friction_curve(model: TorqueModel) -> TorqueModel:
    """A model whose friction may have any shape; as it is where it has a Stribeck term of its own."""
    if any(isinstance(effect, Stribeck) for effect in model.effects):
        return model
    robot = model.robot
    top = np.abs(robot.limits.velocity).max(axis=1)
    widths = {e.joint: e.width for e in model.effects if isinstance(e, Coulomb)}
    terms = []
    for j, joint in enumerate(robot.joints):
        speed = float(top[j]) if np.isfinite(top[j]) else joint.speed(USUAL_SPEED)
        terms += [Stribeck(j, share * speed, width=widths.get(j, 0.0)) for share in SHARES]
    return model.with_effects(*terms)
