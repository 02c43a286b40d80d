"""The designs that are run on the arm, and the test trajectories."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.design.criteria import Criterion
from oed.design.optimisers import interior_point
from oed.design.optimisers.result import Budget
from oed.design.problem import DesignProblem
from oed.design.trajectories.harmonic import HarmonicClass
from oed.dynamics.motion import Motion
from oed.robot.builtin import imi_scara
from studies.case_runner import Outcome
from studies.paper_experiment.searches import DesignConfig, Search, Searches, paper_class, problem
from studies.paper_experiment.stage_cache import StageCache, packed

CRITERIA: tuple[Criterion, Criterion] = ("J_k", "J_d")
# In the order of every table: the genetic algorithm's under the paper's limits (12), then the
# interior-point method's under the limits themselves.
KINDS = ("J_k, GA", "J_d, GA", "J_k, exact limits", "J_d, exact limits")


@dataclass(frozen=True)
class DesignSet:
    """The designs that are run on the arm, and the test trajectories.

    Attributes:
        z: (K, P, size) of each of `KINDS` and each seed.
        J_k: (K, P) cond Lambda at the samples.
        J_d: (K, P) log10 det Lambda at the samples.
        margin: (K, P) proven worst violation of a limit, relative; not above 0 where kept.
        tests: (T, size) random members of the paper's class.
        shown: (2,) the seeds of the figures, by `run_to_show`.
        neighbours: (2,) the best J_k and J_d of what differs from those in a single bit.
    """

    z: Float[ndarray, "K P size"]
    J_k: Float[ndarray, "K P"]
    J_d: Float[ndarray, "K P"]
    margin: Float[ndarray, "K P"]
    tests: Float[ndarray, "T size"]
    shown: Int[ndarray, "2"]
    neighbours: Float[ndarray, "2"]


@dataclass(frozen=True)
class ExactDesign:
    """One design under the limits themselves.

    Attributes:
        criterion: Its own.
        horizon: T [s].
        terms: W.
        samples: Instants of the criterion.
        evaluations: Of it.
        seed: Of all designs.
        run: Which; with the rest it decides where it starts.
    """

    criterion: Criterion
    horizon: float
    terms: int
    samples: int
    evaluations: int
    seed: int
    run: int

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        return (self.criterion, str(self.run))


def design_all(
    config: DesignConfig, horizon: float, searches: Searches, cache: StageCache
) -> DesignSet:
    """The designs of every kind and seed, and the test trajectories."""
    genetic_runs = (searches.condition, searches.determinant)
    narrow = paper_class(horizon, config.terms)
    wide = wide_class(horizon, config.terms)
    problems = [problem(c, j, config.samples) for c in (narrow, wide) for j in CRITERIA]
    shown = [
        run_to_show(spec, found, config)
        for spec, found in zip(problems, genetic_runs, strict=False)
    ]
    common = (horizon, config.terms, config.samples, config.exact_evaluations, config.seed)
    todo = [ExactDesign(j, *common, run) for j in CRITERIA for run in range(config.pairs)]
    exact = [x["z"] for x in cache.each("exact_limits", ("criterion", "run"), within_limits, todo)]
    z = [
        *(found.z[: config.pairs] for found in genetic_runs),
        exact[: config.pairs],
        exact[config.pairs :],
    ]
    worths = [[spec.worth(x) for x in own] for spec, own in zip(problems, z, strict=True)]
    rng = np.random.default_rng([config.seed, 99])
    return DesignSet(
        np.array(z),
        *(np.array([[w[j] for w in own] for own in worths]) for j in ("J_k", "J_d_log10")),
        margin=np.array(
            [
                [spec.certificate(x).violation for x in own]
                for spec, own in zip(problems, z, strict=True)
            ]
        ),
        tests=np.array([problems[0].random_start(rng) for _ in range(config.tests)]),
        shown=np.array([run for run, _ in shown]),
        neighbours=np.array([neighbour for _, neighbour in shown]),
    )


def wide_class(horizon: float, terms: int) -> HarmonicClass:
    """Sums of sines under the limits themselves."""
    return HarmonicClass.exact(imi_scara().limits, horizon, terms)


def reference(terms: int, horizon: float, z: ndarray, period: float) -> Motion:
    """What is asked of the arm; both classes of `design_all` read z alike."""
    t = np.arange(round(horizon / period)) * period
    return paper_class(horizon, terms).motion(z, t)


def run_to_show(spec: DesignProblem, found: Search, config: DesignConfig) -> tuple[int, float]:
    """From the middle of all ends towards the best, the first run that has converged.

    Returns:
        The run, and the best of what differs from its end in one bit; the best run if none has
        converged.
    """
    sign = 1 if spec.criterion == "J_k" else -1  # J_k is to be small, J_d large
    ends = sign * found.best[:, -1]
    # From the middle of all on; only those of the first seeds are run on the arm.
    better = [int(run) for run in np.argsort(-ends, kind="stable")[len(ends) // 2 :]]
    seen = [
        (run, best_neighbour(spec, found.z[run], config.bits))
        for run in better
        if run < config.pairs
    ]
    converged = [(run, nearby) for run, nearby in seen if sign * nearby >= ends[run]]
    return (converged or seen[-1:])[0]


def best_neighbour(spec: DesignProblem, z: Float[ndarray, " size"], bits: int) -> float:
    """The best J_k or J_d of all that differ from a genotype in one bit.

    A search that has converged has none better than itself.
    """
    lower, upper = spec.trajectory.bounds.T
    step = (upper - lower) / (2**bits - 1)
    genes = np.round((z - lower) / step).astype(int)
    costs = []
    for gene in range(len(genes)):
        for bit in range(bits):
            flipped = genes.copy()
            flipped[gene] ^= 1 << bit
            costs.append(spec.cost(lower + flipped * step))
    return 10 ** min(costs) if spec.criterion == "J_k" else -min(costs)


def within_limits(one: ExactDesign) -> Outcome:
    """Design by the interior-point method."""
    spec = problem(wide_class(one.horizon, one.terms), one.criterion, one.samples)
    rng = np.random.default_rng([one.seed, 10 + CRITERIA.index(one.criterion), one.run])
    found = interior_point.optimise(spec, Budget(evaluations=one.evaluations), rng)
    return packed({"z": found.z})
