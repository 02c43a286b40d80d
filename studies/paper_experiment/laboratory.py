"""The paper's laboratory made ready: gains for its specification, noise at its level."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.estimation.weights import variances_from_repetitions
from oed.experiment.control import Controller
from oed.experiment.disturbance import Disturbance, calibrate
from oed.experiment.imi_laboratory import Friction, ImiLaboratory
from oed.experiment.observer import HighGainObserver
from oed.experiment.paper_signals import sample_runs
from oed.experiment.simulation import Log, Setup, run

JOINTS = 2
PERIOD = 0.001  # [s], the paper's T
FRICTIONS: tuple[Friction, Friction] = ("plain", "rich")
# First number of every seed of noise, so that no two uses share a draw.
SHOWN, DESIGN, TEST = 1, 2, 3


@dataclass(frozen=True)
class LaboratoryConfig:
    """How experiments are made.

    Attributes:
        laboratory: The arm and what the paper leaves open about it.
        samples: Instants of each repetition that are used.
        repetitions: In each of the estimation, validation and test sets.
        variance_repetitions: M of the paper's variance formula.
        target_variances: The paper's, for the J_k trajectory, to set the disturbance's level.
        seed: Of all noise.
    """

    laboratory: ImiLaboratory = field(default_factory=ImiLaboratory)
    samples: int = 80
    repetitions: int = 6
    variance_repetitions: int = 20
    target_variances: tuple[float, float] = (3.069, 0.157)
    seed: int = 55


@dataclass(frozen=True)
class Bench:
    """The laboratory made ready.

    Attributes:
        stiffness: (n,) K_p [N m/rad].
        damping: (n,) K_d [N m s/rad].
        disturbance_std: (n,) calibrated level [N m].
    """

    stiffness: Float[ndarray, " n"]
    damping: Float[ndarray, " n"]
    disturbance_std: Float[ndarray, " n"]

    @property
    def controller(self) -> Controller:
        """The paper's controller with these gains."""
        stiffness, damping = (tuple(x.tolist()) for x in (self.stiffness, self.damping))
        return Controller(stiffness, damping, HighGainObserver.paper())

    def setup(self, config: LaboratoryConfig, friction: Friction) -> Setup:
        """The laboratory with one or the other friction."""
        disturbance = config.laboratory.quiet().with_std(self.disturbance_std)
        return config.laboratory.setup(friction, self.controller, disturbance)

    def record(
        self,
        config: LaboratoryConfig,
        friction: Friction,
        reference: Motion,
        draw: tuple[int, ...],
        runs: int,
    ) -> Log:
        """Repetitions of a motion, with noise of their own.

        Args:
            config: Of the laboratory.
            friction: Of the arm.
            reference: The motion.
            draw: What tells this noise from all other.
            runs: Repetitions.
        """
        rng = np.random.default_rng([config.seed, FRICTIONS.index(friction), *draw])
        return run(self.setup(config, friction), reference, rng, runs=runs)


def prepare(config: LaboratoryConfig, reference: Motion) -> Bench:
    """Design the gains, and set the disturbance so that the variances are the paper's."""
    laboratory = config.laboratory
    controller = laboratory.controller()

    def variances(disturbance: Disturbance) -> Float[ndarray, " n"]:
        log = run(
            laboratory.setup("plain", controller, disturbance),
            reference,
            np.random.default_rng(config.seed),
            runs=config.variance_repetitions,
        )
        return variances_from_repetitions(
            sample_runs(log, controller.period, config.samples, "online").raw
        )

    found = calibrate(laboratory.quiet(), np.array(config.target_variances), variances)
    return Bench(np.array(controller.stiffness), np.array(controller.damping), np.array(found.std))
