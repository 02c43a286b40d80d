"""How a torque changes with the motion of one joint."""

from __future__ import annotations

from collections.abc import Callable

from oed.dynamics.effects.effect import State
from oed.dynamics.scalars import Scalar, add, mul, sub


def central_slope(
    torque: Callable[[State], list[Scalar]],
    state: State,
    joint: int,
    step: float,
    way: tuple[Scalar, Scalar, Scalar],
) -> list[Scalar]:
    """Central difference of every joint's torque along a change of one joint's q, dq and ddq.

    Args:
        torque: Of a state, joint by joint.
        state: Where.
        joint: That changes.
        step: Of the difference, in the units of `way`.
        way: Change of q, dq and ddq for a unit step.
    """
    own = (state.q[joint], state.dq[joint], state.ddq[joint])
    high, low = (
        torque(state.with_joint(joint, *(add(x, mul(h, d)) for x, d in zip(own, way, strict=True))))
        for h in (step, -step)
    )
    return [mul(0.5 / step, sub(x, y)) for x, y in zip(high, low, strict=True)]
