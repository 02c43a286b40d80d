"""Play in the gear: when the load changes sides, the joint crosses a gap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import no_type_check

import numba
import numpy as np

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.scalars import Scalar

# An estimated inertia may come out too small or negative: a hundredth of its typical size
# keeps the crossing finite.
LEAST_INERTIA = 0.01


@dataclass(frozen=True)
class Backlash(Effect):
    """F_b x/b + c (tau_transmitted - tau_rigid), with x in [-b, b] the place in the gap 2b.

    The dead zone of Nordin and Gutman 2002 with stiff flanks and the position measured at the
    motor. On a flank the load is passed on. When it changes its sign the link leaves the
    flank and coasts: x'' = tau_rigid / M_jj, nothing is transmitted, and the other flank gives
    back the lost momentum in one blow. Two columns: the flank that carries (asymmetric gear
    friction, a preload), and the lost and returned load, whose coefficient is near one.

    Attributes:
        joint: Index of the joint.
        gap: Width 2b of the gap [rad].
        reference: Gives the load and the inertia.
    """

    joint: int
    gap: float
    reference: ReferenceTorque
    name = "backlash"

    def __post_init__(self) -> None:
        if self.gap <= 0:
            raise ValueError(f"{self.gap=} must be positive")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """F_b and c."""
        tag = self.joint + 1
        return (
            Parameter(f"Fb_{tag}", "N m", self.joint),
            Parameter(f"gap_load_{tag}", "1", self.joint),
        )

    @property
    def depends_on(self) -> tuple[str, ...]:
        """The load's changes of sign."""
        return (f"tau_{self.joint + 1}",)

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """x/b, and transmitted less rigid-body torque.

        Raises:
            ValueError: If the state is symbolic.
        """
        motion = state.motion(self.name)
        zeros = np.zeros(len(motion))
        load = self.reference.rigid(state)[self.joint] + zeros
        inertia = self.reference.inertia(state, self.joint) + zeros
        least = LEAST_INERTIA * float(np.median(np.abs(inertia)))
        inertia = np.maximum(inertia, max(least, np.finfo(float).tiny))
        flank, lost = cross_gap(motion.t, load, inertia, self.gap / 2)
        return [{self.joint: flank}, {self.joint: lost}]


@numba.njit
@no_type_check  # compiled: the tests' type checker must not wrap it
def cross_gap(t, load, inertia, half):
    """Place in the gap and torque that it withholds.

    Args:
        t: (samples,) time [s].
        load: (samples,) torque that the arm needs [N m].
        inertia: (samples,) of the arm about the joint [kg m^2].
        half: b [rad].

    Returns:
        (samples,) x/b, and (samples,) transmitted torque less load [N m].
    """
    flank = np.zeros(len(t))
    lost = np.zeros(len(t))
    x = half if load[0] >= 0 else -half
    v = 0.0
    flank[0] = x / half
    for k in range(1, len(t)):
        pressed = (x >= half and load[k] >= 0) or (x <= -half and load[k] <= 0)
        if not pressed:
            step = t[k] - t[k - 1]
            v += load[k] / inertia[k] * step
            x += v * step
            lost[k] = -load[k]
            if abs(x) >= half:  # the blow on the far flank, or back on the near one
                x = half if x > 0 else -half
                lost[k] += inertia[k] * v / step
                v = 0.0
        flank[k] = x / half
    return flank, lost
