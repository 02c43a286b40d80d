"""The trajectories of the paper's experiment: its own two, the best, and how T matters."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.criteria import Criterion, condition, log10_det
from oed.design.optimisers import genetic, interior_point
from oed.design.optimisers.result import Budget
from oed.design.problem import DesignProblem
from oed.design.trajectories.fourier import FourierClass
from oed.design.trajectories.harmonic import HarmonicClass
from oed.design.trajectories.trajectory import TrajectoryClass
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.report.progress import progress
from oed.robot.builtin import imi_scara

# In the order of every table and figure.
NAMES = ("J_k, GA", "J_d, GA", "J_k, exact limits", "J_d, exact limits", "J_d, Fourier", "test")
PAPER_J_K, PAPER_J_D = 13.34, 17.9  # Calafiore 2001, section 5
CRITERIA: tuple[Criterion, Criterion] = ("J_k", "J_d")


@dataclass(frozen=True)
class DesignConfig:
    """How the trajectories are designed.

    Attributes:
        horizons: The paper does not state T; these are tried [s].
        samples: Instants of the criterion, and of every repetition.
        terms: W.
        bits: Of each gene.
        population: Of the genetic algorithm, which the paper does not state.
        generations: Of the genetic algorithm.
        runs: Seeds of the genetic algorithm a horizon.
        more_terms: W tried beside the paper's at the chosen horizon.
        exact_seconds: CPU time of each exact-limits design [s].
        harmonics: Of the periodic design.
        seed: Of every draw here.
    """

    horizons: tuple[float, ...] = (3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
    samples: int = 80
    terms: int = 3
    bits: int = 4
    population: int = 60
    generations: int = 40
    runs: int = 7
    more_terms: tuple[int, ...] = (2, 5)
    exact_seconds: float = 15.0
    harmonics: int = 5
    seed: int = 2001


@dataclass(frozen=True)
class HorizonTable:
    """What the genetic algorithm reaches, by horizon and seed.

    Attributes:
        horizon: (H,) [s].
        J_k: (H, runs) cond Lambda.
        J_d: (H, runs) log10 det Lambda at `samples` instants.
        J_d_half: (H, runs) the same motion at half as many instants.
        speed: (2, H, runs, n) rms joint speed of the J_k and of the J_d designs [rad/s].
        terms: (K,) numbers of sines tried at the chosen horizon.
        J_k_by_terms: (K, runs).
        chosen: () the horizon whose median J_k is nearest to the paper's [s].
    """

    horizon: Float[ndarray, " H"]
    J_k: Float[ndarray, "H runs"]
    J_d: Float[ndarray, "H runs"]
    J_d_half: Float[ndarray, "H runs"]
    speed: Float[ndarray, "2 H runs n"]
    terms: ndarray
    J_k_by_terms: Float[ndarray, "K runs"]
    chosen: ndarray


@dataclass(frozen=True)
class DesignSet:
    """The designs, sampled every millisecond, in the order of `NAMES`.

    Attributes:
        q: (D, N, n) position [rad].
        dq: (D, N, n) velocity [rad/s].
        ddq: (D, N, n) acceleration [rad/s^2].
        J_k: (D,) cond Lambda at the samples.
        J_d: (D,) log10 det Lambda at the samples.
        margin: (D,) proven worst violation of a limit, relative; not above 0 where kept.
        best: (2, G) best J_k and best J_d of each generation.
        mean: (2, G) mean fitness of each generation: J_k geometric, J_d arithmetic.
        best_so_far: (2, G).
    """

    q: Float[ndarray, "D N n"]
    dq: Float[ndarray, "D N n"]
    ddq: Float[ndarray, "D N n"]
    J_k: Float[ndarray, " D"]
    J_d: Float[ndarray, " D"]
    margin: Float[ndarray, " D"]
    best: Float[ndarray, "2 G"]
    mean: Float[ndarray, "2 G"]
    best_so_far: Float[ndarray, "2 G"]

    def motion(self, design: int, period: float) -> Motion:
        """The reference of a design."""
        t = np.arange(self.q.shape[1]) * period
        return Motion(t, self.q[design], self.dq[design], self.ddq[design])


def problem(trajectory: TrajectoryClass, criterion: Criterion, samples: int) -> DesignProblem:
    """The paper's problem: R_v = I while the trajectory is designed."""
    robot = imi_scara()
    model = TorqueModel.standard(robot)
    return DesignProblem(
        model,
        base_parameters(model),
        trajectory,
        robot.limits,
        trajectory.instants(samples),
        criterion,
    )


def sweep_horizons(config: DesignConfig) -> HorizonTable:
    """Run the genetic algorithm over horizons, seeds, and numbers of sines."""
    shape = (len(config.horizons), config.runs)
    J_k, J_d, J_d_half = np.empty(shape), np.empty(shape), np.empty(shape)
    speed = np.empty((len(CRITERIA), *shape, 2))
    for h, horizon in progress(list(enumerate(config.horizons)), "horizons"):
        for run in range(config.runs):
            for criterion in CRITERIA:
                spec, result, _ = evolve(config, horizon, config.terms, criterion, run)
                dq = spec.trajectory.derivative(result.z, spec.trajectory.instants(400), 1)
                speed[CRITERIA.index(criterion), h, run] = np.sqrt((dq**2).mean(axis=0))
                if criterion == "J_k":
                    J_k[h, run] = 10**result.cost
                else:
                    J_d[h, run] = -result.cost
                    half = spec.trajectory.instants(config.samples // 2)
                    halved = dataclasses.replace(spec, instants=half)
                    J_d_half[h, run] = -halved.cost(result.z)
    distance = np.abs(np.log(np.median(J_k, axis=1) / PAPER_J_K))
    chosen = float(config.horizons[int(np.argmin(distance))])
    terms = (config.terms, *config.more_terms)
    by_terms = np.array(
        [
            [10 ** evolve(config, chosen, W, "J_k", run)[1].cost for run in range(config.runs)]
            for W in terms
        ]
    )
    return HorizonTable(
        np.array(config.horizons),
        J_k,
        J_d,
        J_d_half,
        speed,
        np.array(terms),
        by_terms,
        np.array(chosen),
    )


def design_all(config: DesignConfig, horizon: float, period: float) -> DesignSet:
    """Every trajectory of `NAMES` at one horizon."""
    limits = imi_scara().limits
    harmonic = HarmonicClass.conservative(limits, horizon, config.terms)
    wide = HarmonicClass.exact(limits, horizon, config.terms)
    fourier = FourierClass(horizon, limits, config.harmonics)
    found: list[tuple[DesignProblem, ndarray]] = []
    records = []
    for criterion in CRITERIA:
        # The best of the seeds, as its authors would have kept it.
        runs = [evolve(config, horizon, config.terms, criterion, r) for r in range(config.runs)]
        spec, result, generations = min(runs, key=lambda run: run[1].cost)
        found.append((spec, result.z))
        records.append(generations)
    exact: tuple[tuple[TrajectoryClass, Criterion], ...] = (
        (wide, "J_k"),
        (wide, "J_d"),
        (fourier, "J_d"),
    )
    for k, (trajectory, criterion) in progress(list(enumerate(exact)), "exact-limits designs"):
        spec = problem(trajectory, criterion, config.samples)
        rng = np.random.default_rng([config.seed, 10 + k])
        budget = Budget(cpu_seconds=config.exact_seconds)
        found.append((spec, interior_point.optimise(spec, budget, rng).z))
    spec = problem(harmonic, "J_k", config.samples)
    found.append((spec, spec.random_start(np.random.default_rng([config.seed, 99]))))
    t = np.arange(round(horizon / period)) * period
    motions = [spec.trajectory.motion(z, t) for spec, z in found]
    informations = [spec.information(z) for spec, z in found]
    best, mean, so_far = (
        np.array([[getattr(g, name) for g in generations] for generations in records])
        for name in ("best_cost", "mean_cost", "best_so_far")
    )
    return DesignSet(
        *(np.stack([getattr(m, f) for m in motions]) for f in ("q", "dq", "ddq")),
        J_k=np.array([condition(x) for x in informations]),
        J_d=np.array([log10_det(x) for x in informations]),
        margin=np.array([spec.certificate(z).violation for spec, z in found]),
        best=_values(best),
        mean=_values(mean),
        best_so_far=_values(so_far),
    )


def evolve(
    config: DesignConfig, horizon: float, terms: int, criterion: Criterion, run: int
) -> tuple[DesignProblem, genetic.OptimiserResult, tuple[genetic.Generation, ...]]:
    """One run of the paper's genetic algorithm."""
    trajectory = HarmonicClass.conservative(imi_scara().limits, horizon, terms)
    spec = problem(trajectory, criterion, config.samples)
    settings = genetic.GeneticSettings(
        bits=config.bits, population=config.population, generations=config.generations
    )
    rng = np.random.default_rng(
        [config.seed, round(1000 * horizon), terms, CRITERIA.index(criterion), run]
    )
    budget = Budget(evaluations=(config.generations + 2) * config.population)
    return (spec, *genetic.evolve(spec, budget, rng, settings))


def _values(costs: Float[ndarray, "2 G"]) -> Float[ndarray, "2 G"]:
    """Costs as J_k and J_d."""
    return np.stack([10 ** costs[0], -costs[1]])
