"""One experiment as the paper made it, and many more to see what it could have shown."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.energy_model import EnergyModel
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.least_squares import batch_least_squares
from oed.estimation.recursive import recursive_least_squares
from oed.estimation.weights import variances_from_repetitions
from oed.experiment.control import Controller
from oed.experiment.disturbance import Disturbance, calibrate
from oed.experiment.imi_laboratory import Friction, ImiLaboratory
from oed.experiment.observer import HighGainObserver
from oed.experiment.paper_signals import (
    PROCESSINGS,
    Processing,
    processed_signals,
    sample_runs,
)
from oed.experiment.simulation import Log, Setup, run
from oed.robot.builtin import imi_scara

JOINTS = 2
XI = 8  # parameters of the paper's model (16)
# xi of the paper by the names that its columns carry in the torque model.
XI_NAMES = ("Izz_1", "mx_2", "my_2", "Izz_2", "Fc_1", "Fv_1", "Fc_2", "Fv_2")
SETS = ("estimation", "validation", "test")
FRICTIONS: tuple[Friction, Friction] = ("plain", "rich")


@dataclass(frozen=True)
class CampaignConfig:
    """How the experiments are made.

    Attributes:
        laboratory: The arm and what the paper leaves open about it.
        samples: Instants of each repetition that are used.
        repetitions: In each of the estimation, validation and test sets.
        variance_repetitions: M of the paper's variance formula.
        target_variances: The paper's, for the J_k trajectory, to set the disturbance's level.
        seed: Of every draw here.
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

    def setup(self, config: CampaignConfig, friction: Friction) -> Setup:
        """The laboratory with one or the other friction."""
        laboratory = config.laboratory
        return laboratory.setup(friction, controller_of(self), self.disturbance(config))

    def disturbance(self, config: CampaignConfig) -> Disturbance:
        """The calibrated disturbance."""
        return config.laboratory.quiet().with_std(self.disturbance_std)


@dataclass(frozen=True)
class Experiment:
    """One trajectory, one friction, processed one way: what the paper's tables state.

    Attributes:
        variances: (n,) of the torque as logged, over M repetitions [N^2 m^2].
        parameters: (8,) xi-hat.
        covariance: (8, 8) P of (8).
        recursion: (steps, 8) xi-hat after each sample.
        recursion_std: (steps, 8) square roots of diag P.
        rms: (3, n) residual on the sets of `SETS` [N m].
        relative: (3, n) the same over the rms torque.
        torque: (3, rows, n) measured [N m].
        predicted: (3, rows, n) [N m].
    """

    variances: Float[ndarray, " n"]
    parameters: Float[ndarray, "8"]
    covariance: Float[ndarray, "8 8"]
    recursion: Float[ndarray, "steps 8"]
    recursion_std: Float[ndarray, "steps 8"]
    rms: Float[ndarray, "3 n"]
    relative: Float[ndarray, "3 n"]
    torque: Float[ndarray, "3 rows n"]
    predicted: Float[ndarray, "3 rows n"]


@dataclass(frozen=True)
class EnergyComparison:
    """Newton-Euler and energy estimates of the same experiments, equally weighted rows.

    Attributes:
        torque: (E, 8) by Newton-Euler.
        energy: (E, 8) by the energy model.
    """

    torque: Float[ndarray, "E 8"]
    energy: Float[ndarray, "E 8"]


@dataclass(frozen=True)
class ProcessingComparison:
    """Estimates of the same experiments by way of processing W.

    Attributes:
        ways: (W,) names.
        parameters: (W, E, 8) xi-hat.
        rms: (W, E, n) residual [N m].
        variances: (W, n) of the processed torque between repetitions [N^2 m^2].
    """

    ways: ndarray
    parameters: Float[ndarray, "W E 8"]
    rms: Float[ndarray, "W E n"]
    variances: Float[ndarray, "W n"]


def controller_of(bench: Bench) -> Controller:
    """The paper's controller with the bench's gains."""
    return Controller(
        tuple(bench.stiffness.tolist()), tuple(bench.damping.tolist()), HighGainObserver.paper()
    )


def prepare(config: CampaignConfig, reference: Motion) -> Bench:
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


def repetitions(
    config: CampaignConfig, bench: Bench, friction: Friction, reference: Motion, design: int
) -> Log:
    """M repetitions of a trajectory in the virtual laboratory."""
    rng = np.random.default_rng([config.seed, FRICTIONS.index(friction), design])
    setup = bench.setup(config, friction)
    return run(setup, reference, rng, runs=config.variance_repetitions)


def analyse(
    config: CampaignConfig, log: Log, test: Log, period: float, processing: Processing
) -> Experiment:
    """Variances, recursive estimate and validation, as in sections 4 and 5."""
    M, keep = config.repetitions, config.samples
    runs = sample_runs(log, period, keep, processing)
    sets = (
        runs.of(slice(0, M)),
        runs.of(slice(M, 2 * M)),
        sample_runs(test, period, keep, processing).of(slice(0, M)),
    )
    variances = variances_from_repetitions(runs.raw)
    estimate = recursive_least_squares(
        sets[0].regressor, sets[0].tau.ravel(), JOINTS, noise=variances, block=JOINTS
    )
    torque = np.stack([s.tau.reshape(-1, JOINTS) for s in sets])
    parameters = estimate.solution.parameters
    predicted = np.stack([(s.columns @ parameters).reshape(-1, JOINTS) for s in sets])
    rms = np.sqrt(((torque - predicted) ** 2).mean(axis=1))
    return Experiment(
        variances=variances,
        parameters=parameters,
        covariance=estimate.solution.covariance,
        recursion=estimate.parameters,
        recursion_std=estimate.std,
        rms=rms,
        relative=rms / np.sqrt((torque**2).mean(axis=1)),
        torque=torque,
        predicted=predicted,
    )


def compare_processing(
    config: CampaignConfig,
    bench: Bench,
    reference: Motion,
    *,
    friction: Friction,
    experiments: int,
    periodic: bool,
) -> ProcessingComparison:
    """Estimate the same recordings from differently processed signals.

    A periodic reference is run twice through and its second period kept, so that
    "spectral" can take part.
    """
    setup, M, N = bench.setup(config, friction), config.repetitions, len(reference)
    period = setup.controller.period
    played = reference
    if periodic:
        t = np.arange(2 * N) * period
        twice = (np.tile(x, (2, 1)) for x in (reference.q, reference.dq, reference.ddq))
        played = Motion(t, *twice)
    rng = np.random.default_rng([config.seed, 78, FRICTIONS.index(friction), int(periodic)])
    log = run(setup, played, rng, runs=experiments * M)
    if periodic:
        log = dataclasses.replace(log, lead=log.lead + N, samples=N)
    ways: tuple[Processing, ...] = (
        PROCESSINGS if periodic else tuple(p for p in PROCESSINGS if p != "spectral")
    )
    parameters, rms, variances = [], [], []
    for way in ways:
        runs = sample_runs(log, period, config.samples, way)
        parts = [runs.of(slice(e * M, (e + 1) * M)) for e in range(experiments)]
        noise = variances_from_repetitions(runs.raw)
        found = [
            batch_least_squares(p.regressor, p.tau.ravel(), JOINTS, noise=noise).parameters
            for p in parts
        ]
        residuals = [p.tau - p.columns @ xi for p, xi in zip(parts, found, strict=True)]
        parameters.append(found)
        rms.append([np.sqrt((r**2).mean(axis=(0, 1))) for r in residuals])
        variances.append(variances_from_repetitions(runs.tau))
    return ProcessingComparison(
        np.array(ways), np.array(parameters), np.array(rms), np.array(variances)
    )


def compare_energy(
    config: CampaignConfig,
    bench: Bench,
    reference: Motion,
    processing: Processing,
    *,
    friction: Friction,
    experiments: int,
) -> EnergyComparison:
    """Estimate the same recordings by Newton-Euler and by energy, equally many rows of each."""
    setup, M = bench.setup(config, friction), config.repetitions
    period = setup.controller.period
    model = TorqueModel.standard(imi_scara())
    base = base_parameters(model)
    order = [base.names.index(name) for name in XI_NAMES]
    window = max(1, len(reference) // config.samples)
    rng = np.random.default_rng([config.seed, 77, FRICTIONS.index(friction)])
    log = run(setup, reference, rng, runs=experiments * M)
    signals = processed_signals(log, period, processing)
    proper = slice(log.lead, log.lead + log.samples)
    sampled = sample_runs(log, period, config.samples, processing)
    form = EnergyModel(model, window)
    rows, works = [], []
    for r in range(experiments * M):
        q, dq, ddq, tau = (np.ascontiguousarray(x[proper, :, r]) for x in signals)
        motion = Motion(reference.t, q, dq, ddq)
        rows.append(base.reduce(form.regressor(motion))[:, order])
        works.append(form.target(motion, tau))
    energy, torque = [], []
    for e in range(experiments):
        mine = slice(e * M, (e + 1) * M)
        energy.append(
            np.linalg.lstsq(np.concatenate(rows[mine]), np.concatenate(works[mine]), rcond=None)[0]
        )
        part = sampled.of(mine)
        torque.append(batch_least_squares(part.regressor, part.tau.ravel(), JOINTS).parameters)
    return EnergyComparison(np.array(torque), np.array(energy))
