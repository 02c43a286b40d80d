"""What an arm carries: ten parameters of a body that can exist, and how well each is known."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy import stats

from oed.estimation.feasible.solve import FeasibleSolution
from oed.estimation.load.consistent_body import LEAST_MASS, ball, consistent_body, radius_of
from oed.estimation.load.fit import Fit, fit
from oed.estimation.load.known_arm import KnownArm
from oed.estimation.load.loaded_model import ENTRIES, LoadedModel
from oed.estimation.load.quantities import (
    LEVEL,
    LinearEstimate,
    Quantity,
    quantities,
)
from oed.estimation.load.torque_equations import TorqueEquations
from oed.experiment.preparation.processed import ProcessedRecording
from oed.robot.attached_frame import AttachedFrame
from oed.robot.inertia import pseudo_inertia


@dataclass(frozen=True)
class LoadFriction:
    """Friction that grows with what a gear carries, and what leaving it out would do.

    Attributes:
        mu: (n,) share of the load.
        interval: (n, 2) at 95 %.
        mass_without: The load's mass where the model lacks it [kg].
        interval_without: Of that mass; None where the data do not bound it.
    """

    mu: Float[ndarray, " joints"]
    interval: Float[ndarray, "joints 2"]
    mass_without: float
    interval_without: tuple[float, float] | None

    @property
    def found(self) -> tuple[int, ...]:
        """Joints whose interval lies above zero."""
        return tuple(np.flatnonzero(self.interval[:, 0] > 0).tolist())


@dataclass(frozen=True)
class Payload:
    """A load and how well it is known.

    Attributes:
        frame: Where it is held; all numbers are about it and in its axes.
        parameters: (10,) of a body that can exist.
        quantities: Mass, centre of mass, inertia about it.
        linear: What the data say before any demand.
        friction: Load-dependent friction; None where the model has none.
        arm: What was known of the arm.
        model: Of the arm with its load.
        fit: Of the recordings with the load.
        equations: Of these.
        solution: The proof that the body is the nearest one.
    """

    frame: AttachedFrame
    parameters: Float[ndarray, "10"]
    quantities: tuple[Quantity, ...]
    linear: LinearEstimate
    friction: LoadFriction | None
    arm: KnownArm
    model: LoadedModel
    fit: Fit
    equations: TorqueEquations
    solution: FeasibleSolution

    def __getitem__(self, name: str) -> Quantity:
        return next(quantity for quantity in self.quantities if quantity.name == name)

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return float(self.parameters[0])

    @property
    def centre(self) -> Float[ndarray, "3"]:
        """Centre of mass in the frame [m]."""
        return self.parameters[1:4] / self.parameters[0]

    @property
    def is_felt(self) -> bool:
        """Whether the mass is told from nothing at all."""
        interval = self["mass"].interval
        return interval is not None and interval[0] > 0

    @property
    def margin(self) -> float:
        """Least eigenvalue of the pseudo-inertia, positive for a body that can exist."""
        return float(np.linalg.eigvalsh(pseudo_inertia(self.parameters))[0])

    @property
    def relative_rms(self) -> Float[ndarray, " joints"]:
        """Residual over torque of each joint, with the load."""
        return np.sqrt(
            np.mean(self.fit.residual**2, axis=0) / np.mean(self.equations.torque**2, axis=0)
        )


def estimate_payload(arm: KnownArm, recordings: Sequence[ProcessedRecording]) -> Payload:
    """Weigh what an arm holds.

    Args:
        arm: What is known of it without the load.
        recordings: With the load.

    Raises:
        SolverFailed: If no body is found, which only rounding could do.
    """
    model = arm.model.loaded()
    equations = TorqueEquations.of(model, recordings)
    found = fit(equations, arm.prior(equations))
    phi = found.parameters[model.load]
    covariance = found.covariance[model.load, model.load]
    selection = np.linalg.inv(model.frame.from_body)[list(model.kept)]
    start = _start(phi, covariance, model)
    body, solution = consistent_body(phi, covariance, selection, start)
    linear = _in_frame(model, found, body)
    mass = max(float(body[0]), LEAST_MASS)
    radius = radius_of(mass)
    size = np.array([mass, *(radius,) * 3, *ball(mass, np.zeros(3))[4:]])
    return Payload(
        frame=model.frame,
        parameters=body,
        quantities=quantities(linear, body, size),
        linear=linear,
        friction=None,
        arm=arm,
        model=model,
        fit=found,
        equations=equations,
        solution=solution,
    )


def with_friction(payload: Payload, without: Payload) -> Payload:
    """A payload with what its load-dependent friction is, beside an estimate without any."""
    place = payload.model.load_friction
    mu = payload.fit.parameters[place]
    std = np.sqrt(np.diag(payload.fit.covariance)[place])
    reach = stats.t.ppf(0.5 + LEVEL / 2, payload.fit.degrees_of_freedom[place]) * std
    interval = np.column_stack([mu - reach, mu + reach])
    found = LoadFriction(mu, interval, without.mass, without["mass"].interval)
    return dataclasses.replace(payload, friction=found)


def _start(
    phi: Float[ndarray, " kept"], covariance: Float[ndarray, "kept kept"], model: LoadedModel
) -> Float[ndarray, "10"]:
    """A ball of the mass and at the place that the data tell, about the frame."""
    full = np.zeros(ENTRIES)
    full[list(model.kept)] = phi
    has_mass = 0 in model.kept
    deviation = float(np.sqrt(covariance[0, 0])) if has_mass else 0.0
    mass = max(float(full[0]), deviation, LEAST_MASS)
    centre = full[1:4] / mass
    held = np.isin([1, 2, 3], model.kept)
    centre_F = model.frame.R_JF.T @ (np.where(held, centre, model.frame.p_JF) - model.frame.p_JF)
    return ball(mass, centre_F)


def _in_frame(model: LoadedModel, found: Fit, body: Float[ndarray, "10"]) -> LinearEstimate:
    """The estimate about the frame; what no torque depends on is the body's."""
    kept = list(model.kept)
    about_body = model.frame.from_body
    full = np.linalg.solve(about_body, body)
    full[kept] = found.parameters[model.load]
    covariance = np.zeros((ENTRIES, ENTRIES))
    covariance[np.ix_(kept, kept)] = found.covariance[model.load, model.load]
    freedom = np.full(ENTRIES, np.inf)
    freedom[kept] = found.degrees_of_freedom[model.load]
    uses = np.abs(about_body) > 1e-9
    rest = [k for k in range(ENTRIES) if k not in kept]
    return LinearEstimate(
        parameters=about_body @ full,
        covariance=about_body @ covariance @ about_body.T,
        degrees_of_freedom=np.array([freedom[row].min() for row in uses]),
        is_open=about_body[:, rest],
    )
