"""The torque that a model predicts with the parameters known so far.

Some effects grow with the torque itself: friction under load, a wrong gain, a delay. They
are linear in their own parameter once the torque is taken from the current estimate, and
are evaluated again after each refit.
"""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.effect import Effect, State, recall_effects, with_columns
from oed.dynamics.effects.rigid_body import RigidBody
from oed.dynamics.effects.slopes import central_slope
from oed.dynamics.effects.wiener import expected
from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import inverse_dynamics, regressor_entries
from oed.dynamics.scalars import Scalar, add
from oed.robot import Robot

STEP = 1e-4  # [rad or m] of central differences: their error is its square, far above rounding
SHORTEST = 100  # samples whose spectrum tells anything
REMEMBERED = 96  # torques of a few recordings: a scan asks for the same ones at each trial value


@dataclass(frozen=True)
class ReferenceTorque:
    """A torque model with numbers for its parameters.

    It remembers torques of the last sampled motions: a scan asks for the same ones again and again.

    Attributes:
        robot: Carries the estimated standard parameters; they need not be physical.
        others: Effects beside the rigid body.
        coefficients: One for each parameter of `others`, in order.
    """

    robot: Robot
    others: tuple[Effect, ...] = ()
    coefficients: tuple[float, ...] = ()

    @classmethod
    def of(
        cls,
        robot: Robot,
        effects: Sequence[Effect],
        parameters: Float[ndarray, " parameters"],
    ) -> ReferenceTorque:
        """Split a model's parameter vector into the rigid body's and the rest.

        Args:
            robot: The model's robot.
            effects: The model's effects, in the order of the parameters.
            parameters: All of them.

        Raises:
            ValueError: If the lengths disagree.
        """
        expected = sum(len(effect.parameters) for effect in effects)
        if len(parameters) != expected:
            raise ValueError(f"{len(parameters)} values for a model of {expected} parameters")
        standard = np.zeros(10 * robot.n)
        others: list[Effect] = []
        coefficients: list[float] = []
        for effect, place in with_columns(effects):
            values = parameters[place]
            if isinstance(effect, RigidBody):
                robot, standard = effect.robot, standard + values
            else:
                others.append(effect)
                coefficients += [float(value) for value in values]
        return cls(robot.with_parameters(standard), tuple(others), tuple(coefficients))

    def rigid(self, state: State) -> list[Scalar]:
        """Rigid-body torque of every joint [N m]."""
        return self._remembered(
            "rigid", state, lambda: inverse_dynamics(self.robot, state.q, state.dq, state.ddq)
        )

    def weight(self, state: State) -> list[Scalar]:
        """Rigid-body torque of every joint at rest [N m]."""
        rest = [0.0] * self.robot.n
        return self._remembered(
            "weight", state, lambda: inverse_dynamics(self.robot, state.q, rest, rest)
        )

    def gravity(self, state: State, gravity: Float[ndarray, "3"]) -> list[Scalar]:
        """Torque of the arm at rest under another gravity [m/s^2]."""
        rest = [0.0] * self.robot.n
        return inverse_dynamics(self.robot.with_gravity(gravity), state.q, rest, rest)

    def link_columns(self, state: State, link: int) -> list[dict[int, Scalar]]:
        """Regressor columns of a link's ten parameters, by the joints that they move."""
        own = slice(10 * link, 10 * link + 10)
        return self._remembered(
            f"columns {link}",
            state,
            lambda: regressor_entries(self.robot, state.q, state.dq, state.ddq, {link})[own],
        )

    def expected(self, state: State, joint: int) -> list[Scalar]:
        """Rigid-body torque of a joint [N m] and of a rotor of unit inertia, less encoder noise.

        What the motion is known to drive, not what differentiated noise would: for what resonates.
        """
        return self._remembered(f"expected {joint}", state, lambda: self._expected(state, joint))

    def inertia(self, state: State, joint: int) -> Scalar:
        """Diagonal entry M_jj of the inertia matrix [kg m^2]."""
        return self._column(state, joint)[joint]

    def inertia_at(self, posture: tuple[float, ...], joint: int) -> float:
        """M_jj at one posture [kg m^2]."""
        key = (joint, posture)
        if key not in self._inertias:
            rest = [0.0] * len(posture)
            state = State(0.0, posture, rest, rest)
            self._inertias[key] = float(self._inertia(state, joint)[joint])
        return self._inertias[key]

    def rotor(self, state: State, joint: int) -> list[Scalar]:
        """Torque of every joint for a rotor of unit inertia that turns with a joint's body.

        A slider's rotor is turned by the slide alone: unit mass at its own joint.
        """
        return self._remembered(
            f"rotor {joint}", state, lambda: self._rotor(joint, state.q, state.dq, state.ddq)
        )

    def rotor_inertia(self, state: State, joint: int) -> list[Scalar]:
        """The same for unit acceleration of that joint, all others at rest."""
        rest = [0.0] * self.robot.n
        ddq = [1.0 if j == joint else 0.0 for j in range(self.robot.n)]
        return self._remembered(
            f"rotor inertia {joint}", state, lambda: self._rotor(joint, state.q, rest, ddq)
        )

    def slopes(self, state: State, joint: int) -> list[tuple[Scalar, Scalar, Scalar]]:
        """Derivatives of every joint's rigid torque by q, dq and ddq of one joint.

        Central differences by q and dq; the last is a column of the inertia matrix.
        """
        return self._remembered(f"slopes {joint}", state, lambda: self._slopes(state, joint))

    def slopes_beside(self, state: State, joint: int) -> list[tuple[Scalar, Scalar, Scalar]]:
        """The same of all other effects, that by dq times dq: friction turns its sign where dq does."""
        return self._remembered(
            f"slopes beside {joint}", state, lambda: self._slopes_beside(state, joint)
        )

    def beside_rigid(self, state: State) -> list[Scalar]:
        """Torque of all other effects of every joint [N m]."""
        return self._remembered("rest", state, lambda: self._beside_rigid(state))

    def total(self, state: State) -> list[Scalar]:
        """Torque of every joint [N m]."""
        pairs = zip(self.rigid(state), self.beside_rigid(state), strict=True)
        return [add(rigid, other) for rigid, other in pairs]

    @property
    def keeps(self) -> tuple[str, ...]:
        """What its other effects keep from one instant to the next."""
        return tuple(name for effect in self.others for name in effect.keeps)

    def begin(self, state: State) -> list[Scalar]:
        """What they remember at the first instant of a motion."""
        return [value for effect in self.others for value in effect.begin(state)]

    def recall(
        self, state: State, memory: Sequence[Scalar], step: float
    ) -> tuple[ReferenceAt, list[Scalar]]:
        """The torque at one instant after others, and the memory at the next; as `Effect.recall`."""
        sizes = np.array(self.coefficients)
        found = recall_effects(self.others, sizes, state, memory, step)
        beside = tuple(found[0].get(joint, 0.0) for joint in range(self.robot.n))
        return ReferenceAt(self.robot, self.others, self.coefficients, beside), found[1]

    def parts(self, motion: Motion) -> Float[ndarray, "samples joints 2"]:
        """Rigid-body torque and the rest over a motion [N m]."""
        state = State.along(motion)
        result = np.zeros((len(motion), self.robot.n, 2))
        for part, torques in enumerate((self.rigid(state), self.beside_rigid(state))):
            for joint, torque in enumerate(torques):
                result[:, joint, part] = torque
        return result

    def _rotor(
        self, joint: int, q: Sequence[Scalar], dq: Sequence[Scalar], ddq: Sequence[Scalar]
    ) -> list[Scalar]:
        body = self.robot.joints[joint]
        if body.kind == "prismatic":
            return [ddq[joint] if i == joint else 0.0 for i in range(self.robot.n)]
        parameters = np.zeros(10 * self.robot.n)
        parameters[10 * joint + 4 : 10 * joint + 10] = np.outer(body.axis, body.axis)[
            np.triu_indices(3)
        ]
        rotor = self.robot.with_parameters(parameters).with_gravity(np.zeros(3))
        return inverse_dynamics(rotor, q, dq, ddq)

    def _inertia(self, state: State, joint: int) -> list[Scalar]:
        rest = [0.0] * self.robot.n
        ddq = [1.0 if j == joint else 0.0 for j in range(self.robot.n)]
        weightless = self.robot.with_gravity(np.zeros(3))
        return inverse_dynamics(weightless, state.q, rest, ddq)

    def _column(self, state: State, joint: int) -> list[Scalar]:
        """M_ij of all joints i [kg m^2]."""
        return self._remembered(f"inertia {joint}", state, lambda: self._inertia(state, joint))

    def _expected(self, state: State, joint: int) -> list[Scalar]:
        exact = [self.rigid(state)[joint], self.rotor(state, joint)[joint]]
        motion = state.sampled
        if motion is None or motion.noise is None or len(motion) < SHORTEST:
            return exact
        pairs = zip(self._column(state, joint), motion.noise, strict=True)
        noise = sum(float(np.mean(np.square(m))) * density for m, density in pairs)
        signals = [np.asarray(x + np.zeros(len(motion))) for x in exact]
        return [*expected(signals, 1 / float(np.median(np.diff(motion.t))), noise)]

    def _slopes(self, state: State, joint: int) -> list[tuple[Scalar, Scalar, Scalar]]:
        def rigid(there: State) -> list[Scalar]:
            return inverse_dynamics(self.robot, there.q, there.dq, there.ddq)

        by_q = central_slope(rigid, state, joint, STEP, (1.0, 0.0, 0.0))
        # Quadratic in dq: a step of one is exact.
        by_dq = central_slope(rigid, state, joint, 1.0, (0.0, 1.0, 0.0))
        return list(zip(by_q, by_dq, self._column(state, joint), strict=True))

    def _slopes_beside(self, state: State, joint: int) -> list[tuple[Scalar, Scalar, Scalar]]:
        ways = (
            ("q", STEP, (1.0, 0.0, 0.0)),
            ("dq", STEP, (0.0, state.dq[joint], 0.0)),
            ("ddq", 1.0, (0.0, 0.0, 1.0)),
        )
        found = []
        for name, step, way in ways:
            changing = partial(self._beside_rigid, along=f"{name}_{joint + 1}")
            found.append(central_slope(changing, state, joint, step, way))
        return list(zip(*found, strict=True))

    def _beside_rigid(self, state: State, *, along: str | None = None) -> list[Scalar]:
        """Torque of all other effects, or of those that one coordinate changes [N m]."""
        torque: list[Scalar] = [0.0] * self.robot.n
        sizes = np.array(self.coefficients)
        for effect, place in with_columns(self.others):
            if along is not None and not effect.changes_along(along):
                continue
            for joint, own in effect.torque(state, sizes[place]).items():
                torque[joint] = add(torque[joint], own)
        return torque

    def __getstate__(self) -> dict[str, object]:
        """What another process has to be told: nothing that it can work out."""
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}

    @cached_property
    def _inertias(self) -> dict[tuple[int, tuple[float, ...]], float]:
        return {}

    @cached_property
    def _memory(self) -> OrderedDict[tuple[str, bytes], list]:
        return OrderedDict()

    def _remembered(self, what: str, state: State, compute: Callable[[], list]) -> list:
        fingerprint = state.fingerprint
        if fingerprint is None:
            return compute()
        key = (what, fingerprint)
        if key not in self._memory:
            self._memory[key] = compute()
        self._memory.move_to_end(key)
        if len(self._memory) > REMEMBERED:
            self._memory.popitem(last=False)
        return self._memory[key]


@dataclass(frozen=True)
class ReferenceAt(ReferenceTorque):
    """A reference torque at one instant after others.

    Attributes:
        beside: (n,) torque of all other effects at that instant.
    """

    beside: tuple[Scalar, ...] = ()

    def _beside_rigid(self, state: State, *, along: str | None = None) -> list[Scalar]:  # noqa: ARG002  # of that instant alone
        return list(self.beside)
