"""What is known of an arm before its load is weighed: a prior of beta and mu, with where it is from.

Three ways lead to it: recordings of the bare arm, a model that was identified before, or no more than
the inertials of the robot's file. The load is then estimated in one and the same way.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import block_diag

from oed.dynamics.effects import with_columns
from oed.dynamics.effects.load import LoadFriction
from oed.dynamics.friction_curve import with_friction_curve
from oed.dynamics.torque_model import TorqueModel
from oed.errors import NoUsableResult
from oed.estimation.load.fit import Fit, fit
from oed.estimation.load.friction_change import friction_change
from oed.estimation.load.loaded_model import ENTRIES, LoadedModel
from oed.estimation.load.torque_equations import TorqueEquations
from oed.estimation.prior import Prior
from oed.experiment.preparation.processed import ProcessedRecording
from oed.robot.attached_frame import AttachedFrame
from oed.robot.inertia import pseudo_inertia
from oed.robot.placeholder_inertia import placeholder_reasons

Route = Literal["both logs", "model", "robot file"]

# A parameter of which nothing is known may make this many times the torque that was recorded.
WIDE = 10.0
# Friction of a gear loses between a fifth and two fifths of what it transmits in harmonic drives
# (Harmonic Drive AG, efficiency of 60 to 80 %), less in others.
LOAD_FRICTION = 0.2
# Inertials of makers' files beside identified ones: a third, by link.
FILE_DEVIATION = 0.3


@dataclass(frozen=True)
class FoundArm:
    """A torque model with numbers.

    Attributes:
        name: Of it, for the user.
        torque_model: Of the bare arm.
        parameters: (p,) of all its columns.
        covariance: (p, p), zero where nothing was estimated.
    """

    name: str
    torque_model: TorqueModel
    parameters: Float[ndarray, " p"]
    covariance: Float[ndarray, "p p"]

    def with_open_curve(self) -> FoundArm:
        """The same with friction of any shape over speed, of which nothing was estimated."""
        model = with_friction_curve(self.torque_model)
        more = len(model.parameters) - len(self.parameters)
        return FoundArm(
            self.name,
            model,
            np.pad(self.parameters, (0, more)),
            np.pad(self.covariance, ((0, more), (0, more))),
        )

    def without_load_friction(self) -> tuple[FoundArm, dict[int, tuple[float, float]]]:
        """The same without friction under load, and by joint what that is: mu and its variance.

        In such a model it is that of the bare arm's own torque; the load's is added to it.
        """
        kept, columns, mu = [], [], {}
        for effect, place in with_columns(self.torque_model.effects):
            if (
                isinstance(effect, LoadFriction)
                and len(effect.parameters) == 1
                and not effect.share
            ):
                at = place.start
                mu[effect.joint] = (float(self.parameters[at]), float(self.covariance[at, at]))
            else:
                kept.append(effect)
                columns += range(place.start, place.stop)
        model = dataclasses.replace(self.torque_model, effects=tuple(kept))
        covariance = self.covariance[np.ix_(columns, columns)]
        return FoundArm(self.name, model, self.parameters[columns], covariance), mu


@dataclass(frozen=True)
class KnownArm:
    """A Gaussian prior of the bare arm's parameters.

    Attributes:
        model: Of the bare arm.
        mean: (x,) of its parameters.
        covariance: (x, x).
        route: Where it is from.
        words: The same in one sentence.
        fit: Of the bare recordings, where there are any.
    """

    model: LoadedModel
    mean: Float[ndarray, " x"]
    covariance: Float[ndarray, "x x"]
    route: Route
    words: str
    fit: Fit | None = None

    @classmethod
    def from_recordings(
        cls, model: LoadedModel, recordings: Sequence[ProcessedRecording]
    ) -> KnownArm:
        """Estimated from recordings of the bare arm."""
        equations = TorqueEquations.of(model, recordings)
        found = fit(equations, _wide(equations))
        words = (
            "both logs: rigid body common, friction of each day its own, the load in one of them"
        )
        return cls(model, found.parameters, found.covariance, "both logs", words, found)

    @classmethod
    def from_file(cls, model: LoadedModel, recordings: Sequence[ProcessedRecording]) -> KnownArm:
        """The inertials of the robot's file, give or take a third; nothing of its friction.

        Args:
            model: Of the bare arm.
            recordings: Whose torque says how wide is wide.

        Raises:
            NoUsableResult: If the file's inertials are placeholders.
        """
        robot = model.arm.robot
        reasons = placeholder_reasons(robot)
        if reasons:
            raise NoUsableResult(
                f"the robot file's inertials are placeholders ({reasons[0]}), and cannot tell the arm "
                "from its load: give a recording of the bare arm by --bare, or a model by --model"
            )
        equations = TorqueEquations.of(model, recordings)
        wide = _wide(equations)
        mean, variances = wide.mean.copy(), 1 / np.sum(wide.factor**2, axis=0)
        inertial = ENTRIES * robot.n
        full = np.zeros(model.base.regrouping.shape[1])
        full[:inertial] = robot.parameters
        own = model.base.regrouping[:, :inertial]
        of_links = own @ block_diag(*map(_spread, robot.parameters.reshape(-1, ENTRIES))) @ own.T
        count = len(model.base)
        mean[:count] = model.base.from_standard(full)
        covariance = np.diag(variances)
        # Of what belongs to a link's body its file tells; drives and friction stay open.
        open_too = [
            bool(row[inertial:].any()) for row in model.base.regrouping
        ]  # such as a rotor that turns with its joint's body
        covariance[:count, :count] = np.where(
            np.outer(open_too, open_too) & np.eye(count, dtype=bool),
            of_links + np.diag(variances[:count]),
            of_links,
        )
        words = (
            f"the robot file's inertials as a prior, {FILE_DEVIATION:.0%} of each link's, as no "
            "recording or model of the bare arm is given: wide"
        )
        return cls(model, mean, covariance, "robot file", words)

    @classmethod
    def from_model(
        cls,
        frame: AttachedFrame,
        found: FoundArm,
        recordings: Sequence[ProcessedRecording],
        *,
        has_load_friction: bool = True,
    ) -> KnownArm:
        """A model that was identified before, with its covariance.

        Args:
            frame: Where a load is held.
            found: The model.
            recordings: Whose torque says how wide is wide, where the model says nothing.
            has_load_friction: Whether friction grows with what a gear carries.
        """
        arm, mu = found.without_load_friction()
        arm = arm.with_open_curve()
        model = LoadedModel.bare(
            arm.torque_model, frame, has_load_friction=has_load_friction
        ).turning_as(recordings)
        wide = _wide(TorqueEquations.of(model, recordings))
        mean, variances = wide.mean.copy(), 1 / np.sum(wide.factor**2, axis=0)
        count = len(model.base)
        mean[:count] = model.base.from_standard(arm.parameters)
        own = model.base.regrouping @ arm.covariance @ model.base.regrouping.T
        covariance = np.diag(variances)
        covariance[:count, :count] = _filled(own, variances[:count])
        if has_load_friction:
            for joint, (value, variance) in mu.items():
                mean[count + joint] = value
                covariance[count + joint, count + joint] = variance
        words = (
            f"the model {found.name}, its covariance carried through, friction of its own on the day "
            "of the load"
        )
        return cls(model, mean, covariance, "model", words)

    def relative_rms(self, recordings: Sequence[ProcessedRecording]) -> Float[ndarray, " joints"]:
        """Residual over torque of each joint, where the arm holds nothing."""
        rows, torque = TorqueEquations.of(self.model, recordings).linearised(self.mean)
        residual = torque - (rows @ self.mean).reshape(torque.shape)
        return np.sqrt(np.mean(residual**2, axis=0) / np.mean(torque**2, axis=0))

    def prior(self, equations: TorqueEquations) -> Prior:
        """Of the arm with a load, of which nothing is known.

        Args:
            equations: Of the loaded arm, along its recordings.
        """
        loaded = equations.model
        arm, count = len(self.model.base), len(loaded.kept)
        here = np.append(np.arange(arm), np.arange(arm, len(self.mean)) + count)
        mean = np.zeros(len(loaded.names))
        mean[here] = self.mean
        covariance = np.diag(np.full(len(mean), HEAVIEST**2))
        covariance[np.ix_(here, here)] = self.covariance
        return Prior.gaussian(mean, covariance + friction_change(equations, mean))


# Of wide variances: a direction that no estimate can know so well was left out of the estimate.
SAYS_NOTHING = 1e-15
# [kg, kg m, kg m^2] of a load's parameters, so wide that nothing is said of them.
HEAVIEST = 1e4


def _filled(covariance: Float[ndarray, "p p"], wide: Float[ndarray, " p"]) -> Float[ndarray, "p p"]:
    """A covariance with the directions of which it says nothing made wide."""
    scale = np.sqrt(wide)
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    filled = np.where(values > SAYS_NOTHING, values, 1.0)
    return (vectors * filled) @ vectors.T * np.outer(scale, scale)


def _wide(equations: TorqueEquations) -> Prior:
    """Each parameter by itself makes at most `WIDE` times the torque; mu is that of a gear."""
    model = equations.model
    rows, torque = equations.linearised(np.zeros(len(model.names)))
    largest = float(np.sqrt(np.mean(torque**2, axis=0)).max())
    count = rows.shape[1] - (model.arm.robot.n if model.has_load_friction else 0)
    sizes = np.sqrt(np.mean(rows[:, :count] ** 2, axis=0))
    std = np.divide(WIDE * largest, sizes, out=np.full(count, WIDE * largest), where=sizes > 0)
    mu = np.full(rows.shape[1] - count, LOAD_FRICTION)
    return Prior.independent(np.zeros(rows.shape[1]), np.append(std, mu))


def _spread(parameters: Float[ndarray, "10"]) -> Float[ndarray, "10 10"]:
    """Covariance of a link's parameters: mass, mass times radius, mass times its square."""
    mass = parameters[0]
    radius = float(np.sqrt(np.trace(pseudo_inertia(parameters)[:3, :3]) / max(mass, 1e-9)))
    units = mass * np.array([1.0, *(radius,) * 3, *(radius**2,) * 6])
    return np.diag((FILE_DEVIATION * units) ** 2)
