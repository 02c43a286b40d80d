"""The paper's experiment on many designs, test motions and draws of the noise, all crossed.

Every pair of designs is run with both frictions and E draws of the noise, and so is every test
motion; each estimate is then asked for the torque of each test motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.weights import variances_from_repetitions
from oed.experiment.paper_signals import Processing, SampledRuns, sample_runs
from oed.experiment.simulation import Log
from studies.case_runner import Outcome
from studies.paper_experiment import energy
from studies.paper_experiment.designs import DesignSet, reference
from studies.paper_experiment.fitting import PLAIN, Sums, regressor, stacked
from studies.paper_experiment.laboratory import (
    DESIGN,
    FRICTIONS,
    JOINTS,
    PERIOD,
    TEST,
    Bench,
    LaboratoryConfig,
)
from studies.paper_experiment.stage_cache import Arrays, StageCache, packed

WAYS: tuple[Processing, ...] = ("online", "aligned", "zero_phase", "parallel")
# The paper's estimate; the same with R_v of the torque as it was filtered; richer friction.
FITS = ("paper", "filtered R_v", "richer friction")
SETS = ("estimation", "validation")
KEY = ("friction", "motion")


@dataclass(frozen=True)
class Estimates:
    """What experiments on designs gave; the axes before those named are F, K, P, E and W.

    Attributes:
        parameters: (fits, c) estimates; the first 8 are xi, zero where a model lacks a column.
        covariance: (2, 8, 8) P of (8), of the first two fits.
        variances: (n,) of the torque as logged, over repetitions [N^2 m^2].
        filtered: (n,) of the torque as it was processed [N^2 m^2].
        rms: (sets, n) what the paper's estimate leaves on the sets of `SETS` [N m].
        relative: (sets, n) the same over the rms torque.
    """

    parameters: Float[ndarray, "*cells fits c"]
    covariance: Float[ndarray, "*cells 2 8 8"]
    variances: Float[ndarray, "*cells n"]
    filtered: Float[ndarray, "*cells n"]
    rms: Float[ndarray, "*cells sets n"]
    relative: Float[ndarray, "*cells sets n"]


@dataclass(frozen=True)
class Campaign(Estimates):
    """F frictions, K kinds of design, P seeds of each, E draws, W processings, T test motions.

    Attributes:
        test_rms: (F, K, P, T, E, W, fits, n) on each test motion [N m].
        test_relative: (F, K, P, T, E, W, fits, n) the same over the rms torque.
        energy: (F, P, E, 2, 8) estimates by the energy model, designs for J_k, signals of
            `energy.WAYS`.
    """

    test_rms: Float[ndarray, "F K P T E W fits n"]
    test_relative: Float[ndarray, "F K P T E W fits n"]
    energy: Float[ndarray, "F P E 2 8"]


@dataclass(frozen=True)
class Conditions:
    """What all recordings of a campaign share.

    Attributes:
        config: Of the laboratory.
        bench: Made ready: the numbers of a `Bench`.
        draws: E.
        horizon: T [s].
        terms: W.
    """

    config: LaboratoryConfig
    bench: tuple[tuple[float, ...], ...]
    draws: int
    horizon: float
    terms: int


@dataclass(frozen=True)
class OnArm:
    """One motion on the arm.

    Attributes:
        conditions: Of all.
        friction: Index in `FRICTIONS`.
        draw: Use and numbers of the motion, which tell its noise from all other.
        z: The motion's variables.
    """

    conditions: Conditions
    friction: int
    draw: tuple[int, ...]
    z: tuple[float, ...]

    @property
    def key(self) -> tuple[str, ...]:
        """What its line begins with."""
        return (FRICTIONS[self.friction], " ".join(map(str, self.draw)))

    def record(self, sets: int) -> Log:
        """Repetitions, of some sets for each draw of the noise."""
        one = self.conditions
        motion = reference(one.terms, one.horizon, np.array(self.z), PERIOD)
        runs = one.draws * sets * one.config.repetitions
        bench = Bench(*map(np.array, one.bench))
        return bench.record(one.config, FRICTIONS[self.friction], motion, self.draw, runs)


def run_campaign(conditions: Conditions, designs: DesignSet, cache: StageCache) -> Campaign:
    """Record, estimate and predict."""
    shape = (len(FRICTIONS), *designs.z.shape[:2])
    todo = [
        OnArm(conditions, f, (DESIGN, k, p), tuple(designs.z[k, p].tolist()))
        for f, k, p in np.ndindex(*shape)
    ]
    found = cache.each("designs_on_arm", KEY, on_design, todo)
    names = [name for name in found[0] if name != "energy"]
    flat = {name: np.stack([own[name] for own in found]) for name in names}
    shaped = {name: part.reshape(*shape, *part.shape[1:]) for name, part in flat.items()}
    works = np.array([own["energy"] for own in found if "energy" in own])
    places = list(np.ndindex(len(FRICTIONS), len(designs.tests)))
    todo = [OnArm(conditions, f, (TEST, t), tuple(designs.tests[t].tolist())) for f, t in places]
    sums = cache.each("test_motions_on_arm", KEY, on_test, todo)
    rms, relative = _predict(shaped["parameters"], dict(zip(places, sums, strict=True)))
    return Campaign(
        **shaped,
        test_rms=rms,
        test_relative=relative,
        energy=works.reshape(shape[0], shape[2], *works.shape[1:]),
    )


def on_design(one: OnArm) -> Outcome:
    """One design: (E, W) estimates, and by the energy model where J_k is the criterion."""
    config, M = one.conditions.config, one.conditions.config.repetitions
    log = one.record(len(SETS))
    firsts = range(0, one.conditions.draws * 2 * M, 2 * M)
    by_way = []
    for way in WAYS:
        runs = sample_runs(log, PERIOD, config.samples, way, regressor=regressor)
        by_way.append(stacked([_estimate(runs.of(slice(i, i + 2 * M)), M) for i in firsts]))
    found = vars(stacked(by_way, axis=1))
    _, kind, _ = one.draw
    if kind > 0:
        return packed(found)
    sets = [range(i, i + M) for i in firsts]
    works = [energy.energy_estimates(log, way, config.samples, sets) for way in energy.WAYS]
    return packed(found | {"energy": np.stack(works, axis=1)})


def _estimate(runs: SampledRuns, repetitions: int) -> Estimates:
    """One experiment: the first half of its runs are fitted, the others validate."""
    first, second = (
        Sums.of(runs.of(part)) for part in (slice(repetitions), slice(repetitions, None))
    )
    logged, filtered = (variances_from_repetitions(tau) for tau in (runs.raw, runs.tau))
    fits = [first.fit(variances, PLAIN) for variances in (logged, filtered)]
    xi = fits[0][0]
    squares = np.stack([part.squared_residual(xi) for part in (first, second)])
    return Estimates(
        np.stack([fits[0][0], fits[1][0], first.fit_rich(logged)]),
        np.stack([covariance for _, covariance in fits]),
        logged,
        filtered,
        np.sqrt(squares),
        np.stack([part.relative(xi) for part in (first, second)]),
    )


def on_test(one: OnArm) -> Outcome:
    """One test motion: (E, W) sums."""
    config, M = one.conditions.config, one.conditions.config.repetitions
    log = one.record(1)
    by_way = [sample_runs(log, PERIOD, config.samples, w, regressor=regressor) for w in WAYS]
    sums = [
        stacked([Sums.of(runs.of(slice(e * M, (e + 1) * M))) for runs in by_way])
        for e in range(one.conditions.draws)
    ]
    return packed(vars(stacked(sums)))


def _predict(
    parameters: Float[ndarray, "F K P E W fits c"], sums: dict[tuple[int, ...], Arrays]
) -> tuple[Float[ndarray, "F K P T E W fits n"], Float[ndarray, "F K P T E W fits n"]]:
    """Rms and relative error of every estimate on every test motion, draw by draw."""
    frictions, kinds, seeds, draws, ways, fits, _ = parameters.shape
    tests = len(sums) // frictions
    rms = np.empty((frictions, kinds, seeds, tests, draws, ways, fits, JOINTS))
    relative = np.empty_like(rms)
    for (f, t), own in sums.items():
        for e, w in np.ndindex(draws, ways):
            part = Sums(**{name: array[e, w] for name, array in own.items()})
            xi = parameters[f, :, :, e, w]
            rms[f, :, :, t, e, w] = np.sqrt(part.squared_residual(xi))
            relative[f, :, :, t, e, w] = part.relative(xi)
    return rms, relative
