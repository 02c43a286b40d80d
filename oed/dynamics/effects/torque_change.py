"""A measurement effect seen as one column: what it changes in the predicted torque."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect, Parameter, State
from oed.dynamics.effects.measurement_effect import MeasurementEffect
from oed.dynamics.effects.reference import ReferenceTorque
from oed.dynamics.motion import Motion
from oed.dynamics.scalars import Scalar


@dataclass(frozen=True)
class TorqueChange(Effect):
    """Torque as measured less torque as modelled, for parameters known so far.

    With a coefficient of one the model plus this column is the model as measured: so a delay
    competes with friction terms column against column before anything is refitted.

    Attributes:
        measurement: Of the columns given to it, the first is the rigid body's torque and the
            second the rest.
        reference: The torque as modelled.
    """

    measurement: MeasurementEffect
    reference: ReferenceTorque
    name = "torque_change"
    offline = "it is worked out along whole recordings"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Share of the change, 1 by construction."""
        return (Parameter(self.measurement.name, "1", None),)

    @property
    def depends_on(self) -> tuple[str, ...]:
        """All joint coordinates."""
        n = self.reference.robot.n
        return tuple(f"{x}_{i + 1}" for x in ("q", "dq", "ddq") for i in range(n))

    def entries(self, state: State) -> Sequence[Mapping[int, Scalar]]:
        """The change of every joint's torque [N m].

        Raises:
            ValueError: If the state is symbolic.
        """
        motion = state.motion(self.measurement.name)
        modelled = self.reference.parts(motion)
        change = self._measured(modelled, motion) - modelled.sum(axis=2)
        return [{j: change[:, j] for j in range(self.reference.robot.n)}]

    def _measured(
        self, modelled: Float[ndarray, "samples joints 2"], motion: Motion
    ) -> Float[ndarray, "samples joints"]:
        """The torque as measured, of the rigid body and of the rest as modelled."""
        forgetful = dataclasses.replace(self.reference)  # a moved motion is not seen again

        def parts(seen: Motion) -> Float[ndarray, "samples joints 2"]:
            return modelled if seen is motion else forgetful.parts(seen)

        rigid = np.array([True, False])
        return self.measurement.through(parts, motion, rigid).sum(axis=2)
