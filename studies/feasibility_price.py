"""What do physical constraints cost in torque residual, and what do they buy?

    python -m studies.feasibility_price [--workers N] [--scheduler ADDRESS] [--smoke] [--seed N]

Calafiore, Indri and Bona (2001) left open how constraints change the residuals where plain least
squares "may lead to physically unfeasible values". Here an arm with known parameters moves well
or badly, long or shortly, under little or much noise; plain least squares meets feasible ones.
"""

from __future__ import annotations

import dataclasses
import itertools
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.commands.options import Seed, parse
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion, random_motion
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.feasible.base_feasibility import base_feasibility
from oed.estimation.feasible.data_factor import DataFactor
from oed.estimation.feasible.estimate import estimate_feasible
from oed.estimation.feasible.mass_matrix import (
    mass_matrices,
    random_poses,
    share_positive_definite,
)
from oed.estimation.feasible.regularisation import Regularisation
from oed.process_end import RESUMES, leave
from oed.robot import Robot
from oed.robot.inertia import parameters_from_pseudo_inertia, pseudo_inertia
from studies.case_runner import CaseRunner, Outcome, RowFile, leave_page, work_through
from studies.elbow_arm import COULOMB, VISCOUS, elbow_arm
from studies.feasibility_summary import summarise
from studies.study_options import CaseOptions

KEY = ("excitation", "noise", "samples", "repeat", "estimator")
VALUES = (
    "condition", "estimation_rms", "validation_error", "parameter_error", "positive_definite",
    "feasible_robot", "seconds", "status",
)  # fmt: skip
ESTIMATORS = ("plain", "feasible", "feasible, prior")


@dataclass(frozen=True)
class Excitation:
    """A class of motions: amplitude [rad] and angular frequencies [rad/s] of its harmonics."""

    name: str
    amplitude: float
    slowest: float
    fastest: float


@dataclass(frozen=True)
class Config:
    """What is simulated.

    Attributes:
        excitations: From bad to good.
        noises: Standard deviation of the torque noise, per torque rms of each joint.
        samples: Of the estimation motion, at `rate`.
        rate: [Hz].
        repeats: Draws of motion and noise for each case.
        poses: At which mass matrices are examined.
        prior_error: Relative error of the prior's masses, lengths and inertias.
        seed: Of everything random.
    """

    excitations: tuple[Excitation, ...] = (
        Excitation("poor", 0.15, 0.5, 1.5),
        Excitation("fair", 0.4, 0.5, 3.0),
        Excitation("good", 0.6, 1.0, 6.0),
    )
    noises: tuple[float, ...] = (0.01, 0.05, 0.2)
    samples: tuple[int, ...] = (50, 200, 1000)
    rate: float = 20.0
    repeats: int = 3
    poses: int = 1000
    prior_error: float = 0.33
    seed: int = 20010219


SMOKE = Config(
    excitations=(Excitation("poor", 0.15, 0.5, 1.5),),
    noises=(0.05,),
    samples=(50,),
    repeats=1,
    poses=50,
)


@dataclass(frozen=True)
class Case:
    """One estimator on one experiment.

    Attributes:
        config: Of the study.
        place: Of the experiment among all: with the study's seed it decides what is drawn.
        excitation: Of the motion.
        noise: Per torque rms.
        samples: Of the motion.
        repeat: Which draw.
        estimator: Of `ESTIMATORS`.
    """

    config: Config
    place: int
    excitation: Excitation
    noise: float
    samples: int
    repeat: int
    estimator: str

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        numbers = (str(self.noise), str(self.samples), str(self.repeat))
        return (self.excitation.name, *numbers, self.estimator)


@dataclass(frozen=True)
class Arm:
    """The true arm and what every case needs of it.

    Attributes:
        model: Rigid body and friction.
        truth: (p,) its parameters.
        base: Its base parameters.
        scales: (b,) torque rms of each base parameter's column at random states.
        poses: (k, n) at which mass matrices are examined.
    """

    model: TorqueModel
    truth: Float[ndarray, " p"]
    base: BaseParameters
    scales: Float[ndarray, " base"]
    poses: Float[ndarray, "k joints"]


def cases_of(config: Config) -> list[Case]:
    """Every estimator on every experiment."""
    choices = itertools.product(
        config.excitations, config.noises, config.samples, range(config.repeats)
    )
    return [
        Case(config, place, *choice, name)
        for place, choice in enumerate(choices)
        for name in ESTIMATORS
    ]


@lru_cache(maxsize=1)
def build_arm(config: Config) -> Arm:
    """The elbow arm, its base parameters and the poses to examine."""
    rng = np.random.default_rng(config.seed)
    model = TorqueModel.standard(elbow_arm())
    truth = np.concatenate(
        [model.robot.parameters, np.column_stack([COULOMB, VISCOUS]).reshape(-1)]
    )
    base = base_parameters(model)
    columns = base.reduce(model.regressor(random_motion(model.robot, 200, rng)))
    return Arm(
        model=model,
        truth=truth,
        base=base,
        scales=np.sqrt(np.mean(columns**2, axis=0)),
        poses=random_poses(model, config.poses, rng),
    )


def work(case: Case) -> Outcome:
    """What an estimator's parameters are worth."""
    config, arm = case.config, build_arm(case.config)
    rng = np.random.default_rng(np.random.SeedSequence(config.seed, spawn_key=(case.place,)))
    model = arm.model
    motion = random_harmonics(case.excitation, model.robot.n, case.samples, config.rate, rng)
    held = random_harmonics(config.excitations[-1], model.robot.n, 400, config.rate, rng)
    clean, held_torque = model.torque(arm.truth, motion), model.torque(arm.truth, held)
    deviation = case.noise * np.sqrt(np.mean(clean**2, axis=0))
    torque = clean + deviation * rng.standard_normal(clean.shape)
    data = DataFactor.of(model.regressor(motion), torque, deviation**2)
    white = arm.base.reduce(data.factor)
    prior = wrong_prior(model.robot, config.prior_error, rng)
    start = time.process_time()
    parameters = _estimate(arm, data, case.estimator, prior)
    seconds = time.process_time() - start
    masses, values = mass_matrices(model, parameters, arm.poses), arm.base.from_standard(parameters)
    return {
        "condition": float(np.linalg.cond(white / np.linalg.norm(white, axis=0))),
        "estimation_rms": float(np.sqrt(data.misfit(parameters))),
        "validation_error": relative_rms(model.torque(parameters, held), held_torque),
        "parameter_error": parameter_error(arm, parameters),
        "positive_definite": share_positive_definite(masses),
        "feasible_robot": base_feasibility(model, arm.base, values).is_feasible,
        "seconds": seconds,
        "status": "done",
    }


def _estimate(
    arm: Arm, data: DataFactor, name: str, prior: Float[ndarray, " inertial"]
) -> Float[ndarray, " p"]:
    if name == "plain":
        reduced = arm.base.reduce(data.factor)
        norms = np.linalg.norm(reduced, axis=0)
        scaled = np.linalg.lstsq(reduced / norms, data.target, rcond=None)[0]
        return arm.base.to_standard(scaled / norms)
    # As a prior density exp(-distance) would: sum of squares plus twice the distance.
    return estimate_feasible(
        arm.model,
        data,
        prior=prior if name == "feasible, prior" else None,
        regularisation=Regularisation(2.0 / data.rows),
    ).parameters


def random_harmonics(
    excitation: Excitation, joints: int, samples: int, rate: float, rng: np.random.Generator
) -> Motion:
    """Three harmonics a joint with random frequency and phase, as (10) of the paper."""
    t = np.arange(samples) / rate
    amplitude = excitation.amplitude * rng.uniform(0.3, 1.0, (3, joints))
    omega = rng.uniform(excitation.slowest, excitation.fastest, (3, joints))
    phase = t[:, None, None] * omega + rng.uniform(0, 2 * np.pi, (3, joints))
    return Motion(
        t=t,
        q=np.sum(amplitude * np.sin(phase), axis=1),
        dq=np.sum(amplitude * omega * np.cos(phase), axis=1),
        ddq=np.sum(-amplitude * omega**2 * np.sin(phase), axis=1),
    )


def wrong_prior(
    robot: Robot, error: float, rng: np.random.Generator
) -> Float[ndarray, " inertial"]:
    """The true bodies, each stretched at random along random axes and of another mass."""
    bodies = []
    for parameters in robot.parameters.reshape(-1, 10):
        stretch = np.eye(4)
        stretch[:3, :3] += error * rng.normal(0, 0.5, (3, 3))
        mass = np.exp(error * rng.normal())
        bodies.append(
            parameters_from_pseudo_inertia(mass * stretch @ pseudo_inertia(parameters) @ stretch.T)
        )
    return np.concatenate(bodies)


def relative_rms(
    found: Float[ndarray, "samples joints"], true: Float[ndarray, "samples joints"]
) -> float:
    """Error of a torque per true torque, mean over joints of the relative rms."""
    return float(np.mean(np.sqrt(np.mean((found - true) ** 2, axis=0) / np.mean(true**2, axis=0))))


def parameter_error(arm: Arm, parameters: Float[ndarray, " p"]) -> float:
    """Error of the base parameters, each in the torque that it makes, per all of them."""
    error, true = (arm.base.from_standard(p) for p in (parameters - arm.truth, arm.truth))
    return float(np.linalg.norm(error * arm.scales) / np.linalg.norm(true * arm.scales))


@dataclass(frozen=True)
class Options(CaseOptions):
    """What does physical feasibility cost in prediction, and what does it save?

    Attributes:
        seed: Of everything random.
    """

    study: ClassVar[str] = "feasibility_price"
    names: ClassVar[tuple[str, ...]] = ("summary.md", "provenance.json")

    seed: Seed = Config.seed


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 1 if all failed, else 0."""
    options = parse(Options, prog="python -m studies.feasibility_price", arguments=arguments)
    config = dataclasses.replace(SMOKE if options.smoke else Config(), seed=options.seed)
    rows, cases = RowFile(options.results / "runs.csv", KEY, VALUES), cases_of(config)

    def write(out: Path) -> None:
        text = summarise(rows.rows_of(case.key for case in cases), config.repeats, config.poses)
        leave_page(text, config, config.seed, out)

    return work_through(CaseRunner(work, rows, "feasibility"), cases, options, config, write)


if __name__ == "__main__":
    leave(main, "studies.feasibility_price", RESUMES)
