"""What every class of trajectories offers to criteria, limits and optimisers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import ClassVar

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.robot import JointLimits

Move = Callable[[Float[ndarray, " size"], np.random.Generator], Float[ndarray, " size"]]


class TrajectoryClass(ABC):
    """A family of joint motions on [0, horizon], one decision vector z a motion.

    Every joint has its own m variables; z holds those of all joints. Subclasses are frozen
    dataclasses, built once for a robot.

    Attributes:
        name: For reports and design files.
        is_linear: Whether position is affine in z, so that limits are linear.
        has_offset: Whether the mean of each joint is free.
        is_periodic: Whether every motion ends as it starts, in position and velocity, so that it
            can be repeated without a way back.
        box_keeps_limits: Whether every point of the box keeps position, velocity and
            acceleration limits.
    """

    name: ClassVar[str]
    is_linear: ClassVar[bool]
    has_offset: ClassVar[bool]
    is_periodic: ClassVar[bool] = False

    horizon: float
    box_keeps_limits: bool = False

    @property
    @abstractmethod
    def joints(self) -> int:
        """Number of joints n."""

    @property
    @abstractmethod
    def bounds(self) -> Float[ndarray, "size 2"]:
        """Finite box of the decision variables."""

    @property
    @abstractmethod
    def variables(self) -> Int[ndarray, "joints own"]:
        """Indices in z of each joint's own variables."""

    @property
    def size(self) -> int:
        """Number of decision variables."""
        return len(self.bounds)

    @abstractmethod
    def derivative(
        self, z: Float[ndarray, " size"], t: Float[ndarray, " samples"], order: int
    ) -> Float[ndarray, "samples joints"]:
        """Exact time derivative of position, of any order from 0 [rad/s^order]."""

    @abstractmethod
    def sensitivity(
        self, z: Float[ndarray, " size"], t: Float[ndarray, " samples"], order: int
    ) -> Float[ndarray, "samples joints own"]:
        """Partial derivatives of `derivative` by each joint's own `variables`."""

    @abstractmethod
    def derivative_bound(self, z: Float[ndarray, " size"], order: int) -> Float[ndarray, " joints"]:
        """An upper bound on |`derivative`| at all t; for order 0 on |position - centre|."""

    @abstractmethod
    def centre(self, z: Float[ndarray, " size"]) -> Float[ndarray, " joints"]:
        """Position about which each joint moves [rad or m]."""

    @abstractmethod
    def shrink(
        self, z: Float[ndarray, " size"], factors: Float[ndarray, " joints"]
    ) -> Float[ndarray, " size"]:
        """The motion with each joint's distance from its centre multiplied by a factor."""

    @abstractmethod
    def shift(
        self, z: Float[ndarray, " size"], distance: Float[ndarray, " joints"]
    ) -> Float[ndarray, " size"]:
        """The motion with each joint's centre moved; unchanged where there is no offset."""

    def draw(self, rng: np.random.Generator) -> Float[ndarray, " size"]:
        """A random point of the box, from which a motion is to be scaled into its limits."""
        return rng.uniform(*self.bounds.T)

    def swing(
        self,
        middle: Float[ndarray, " joints"],  # noqa: ARG002  # of classes that can say
        amplitude: Float[ndarray, " joints"],  # noqa: ARG002
        rate: Float[ndarray, " joints"],  # noqa: ARG002
    ) -> Float[ndarray, " size"] | None:
        """About middle + amplitude sin(rate t), a good first motion; None to start at random."""
        return None

    @property
    def moves(self) -> tuple[Move, ...]:
        """Ways to a neighbouring motion that only this class knows; they may write into z."""
        return ()

    @abstractmethod
    def describe(self, z: Float[ndarray, " size"]) -> dict[str, ndarray]:
        """The coefficients by name, for a design file."""

    @classmethod
    def restore(
        cls,
        horizon: float,  # noqa: ARG003  # of classes that can
        limits: JointLimits,  # noqa: ARG003
        coefficients: Mapping[str, ndarray],  # noqa: ARG003
    ) -> tuple[TrajectoryClass, Float[ndarray, " size"]]:
        """The class and the motion that `describe` described, for a robot of such limits.

        Raises:
            ValueError: If the coefficients describe no motion of as many joints.
        """
        raise ValueError(f"motions of class {cls.name!r} cannot be read back")

    def with_limits(self, limits: JointLimits) -> TrajectoryClass:  # noqa: ARG002  # of its box
        """The class for narrower limits: itself, unless its box depends on them."""
        return self

    def slower(self, scale: float) -> TrajectoryClass:  # noqa: ARG002  # of classes that can
        """The class whose z is the same way through space at `scale` times the speed.

        Raises:
            ValueError: If it has none.
        """
        raise ValueError(f"motions of class {self.name!r} cannot be slowed down")

    def motion(self, z: Float[ndarray, " size"], t: Float[ndarray, " samples"]) -> Motion:
        """Position, velocity and acceleration at instants t [s]."""
        return Motion(np.asarray(t, dtype=float), *(self.derivative(z, t, k) for k in range(3)))

    def pull_back(
        self,
        z: Float[ndarray, " size"],
        t: Float[ndarray, " samples"],
        adjoints: tuple[Float[ndarray, "samples joints"], ...],
    ) -> Float[ndarray, " size"]:
        """Gradient by z of a function whose gradients by q, dq, ddq, ... are `adjoints`."""
        gradient = np.zeros(self.size)
        for order, adjoint in enumerate(adjoints):
            parts = np.einsum("kj,kjm->jm", adjoint, self.sensitivity(z, t, order))
            np.add.at(gradient, self.variables, parts)
        return gradient

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Instants between which position is infinitely often differentiable, ends included."""
        return (0.0, self.horizon)

    def bernstein(
        self,
        z: Float[ndarray, " size"],  # noqa: ARG002  # of classes that are piecewise polynomial
        order: int,  # noqa: ARG002
    ) -> Float[ndarray, "pieces coefficients joints"] | None:
        """`derivative` as polynomials between `breakpoints`, by their Bernstein coefficients.

        With them extrema are found from the polynomials; None for other functions.
        """
        return None

    def limit_instants(self, count: int) -> Float[ndarray, " samples"]:
        """About `count` instants at which an optimiser should first look at limits [s]."""
        return np.linspace(0.0, self.horizon, count)

    def instants(self, count: int) -> Float[ndarray, " samples"]:
        """`count` equally spaced instants k T / count, k = 0 ... count - 1 [s].

        The end of the horizon is left out: in a periodic motion it repeats the start.
        """
        return np.arange(count) * (self.horizon / count)

    def clip(self, z: Float[ndarray, " size"]) -> Float[ndarray, " size"]:
        """The nearest point of the box."""
        return np.clip(z, self.bounds[:, 0], self.bounds[:, 1])
