"""The paper's experiment on many designs, test motions and draws of the noise, all crossed.

Every pair of designs is run with both frictions and E draws of the noise, and so is every test
motion; each estimate is then asked for the torque of each test motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import partial

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.estimation.weights import variances_from_repetitions
from oed.experiment.paper_signals import Processing, SampledRuns, sample_runs
from oed.parallel_map import one_by_one
from oed.report.progress import progress
from studies.paper_experiment import energy
from studies.paper_experiment.fitting import PLAIN, Sums, regressor
from studies.paper_experiment.laboratory import (
    DESIGN,
    FRICTIONS,
    JOINTS,
    PERIOD,
    TEST,
    Bench,
    LaboratoryConfig,
)

WAYS: tuple[Processing, ...] = ("online", "aligned", "zero_phase", "parallel")
# The paper's estimate; the same with R_v of the torque as it was filtered; richer friction.
FITS = ("paper", "filtered R_v", "richer friction")
SETS = ("estimation", "validation")


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

    @classmethod
    def stacked(cls, parts: Sequence[Estimates], axis: int = 0) -> Estimates:
        """Several as one, along a new axis."""
        names = [field.name for field in fields(cls)]
        return cls(*(np.stack([getattr(p, name) for p in parts], axis) for name in names))


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
        bench: Made ready.
        draws: E.
    """

    config: LaboratoryConfig
    bench: Bench
    draws: int


def run_campaign(
    conditions: Conditions, designs: Sequence[Sequence[Motion]], tests: Sequence[Motion]
) -> Campaign:
    """Record, estimate and predict.

    Args:
        conditions: Of all.
        designs: K kinds of P motions.
        tests: T motions.
    """
    shape = (len(FRICTIONS), len(designs), len(designs[0]))
    places = list(np.ndindex(*shape))
    work = partial(_design, conditions, designs)
    found = list(progress(one_by_one(work, places), "designs on the arm", total=len(places)))
    flat = vars(Estimates.stacked([estimates for estimates, _ in found]))
    shaped = {name: part.reshape(*shape, *part.shape[1:]) for name, part in flat.items()}
    works = np.array([energies for _, energies in found if energies is not None])
    places = list(np.ndindex(len(FRICTIONS), len(tests)))
    work = partial(_test, conditions, tests)
    sums = list(progress(one_by_one(work, places), "test motions on the arm", total=len(places)))
    rms, relative = _predict(shaped["parameters"], dict(zip(places, sums, strict=True)))
    return Campaign(
        **shaped,
        test_rms=rms,
        test_relative=relative,
        energy=works.reshape(shape[0], shape[2], *works.shape[1:]),
    )


def _design(
    conditions: Conditions, designs: Sequence[Sequence[Motion]], place: tuple[int, int, int]
) -> tuple[Estimates, Float[ndarray, "E 2 8"] | None]:
    """One design: (E, W) estimates, and by the energy model where J_k is the criterion."""
    friction, kind, seed = place
    config, M = conditions.config, conditions.config.repetitions
    log = conditions.bench.record(
        config,
        FRICTIONS[friction],
        designs[kind][seed],
        (DESIGN, kind, seed),
        runs=conditions.draws * 2 * M,
    )
    firsts = range(0, conditions.draws * 2 * M, 2 * M)
    by_way = []
    for way in WAYS:
        runs = sample_runs(log, PERIOD, config.samples, way, regressor=regressor)
        drawn = [_estimate(runs.of(slice(i, i + 2 * M)), M) for i in firsts]
        by_way.append(Estimates.stacked(drawn))
    found = Estimates.stacked(by_way, axis=1)
    if kind > 0:
        return found, None
    sets = [range(i, i + M) for i in firsts]
    works = [energy.energy_estimates(log, way, config.samples, sets) for way in energy.WAYS]
    return found, np.stack(works, axis=1)


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


def _test(
    conditions: Conditions, tests: Sequence[Motion], place: tuple[int, int]
) -> list[list[Sums]]:
    """One test motion: sums of each draw and processing."""
    friction, test = place
    config, M = conditions.config, conditions.config.repetitions
    log = conditions.bench.record(
        config, FRICTIONS[friction], tests[test], (TEST, test), runs=conditions.draws * M
    )
    by_way = [sample_runs(log, PERIOD, config.samples, w, regressor=regressor) for w in WAYS]
    return [
        [Sums.of(runs.of(slice(e * M, (e + 1) * M))) for runs in by_way]
        for e in range(conditions.draws)
    ]


def _predict(
    parameters: Float[ndarray, "F K P E W fits c"], sums: dict[tuple[int, ...], list[list[Sums]]]
) -> tuple[Float[ndarray, "F K P T E W fits n"], Float[ndarray, "F K P T E W fits n"]]:
    """Rms and relative error of every estimate on every test motion, draw by draw."""
    frictions, kinds, seeds, draws, ways, fits, _ = parameters.shape
    tests = len(sums) // frictions
    rms = np.empty((frictions, kinds, seeds, tests, draws, ways, fits, JOINTS))
    relative = np.empty_like(rms)
    for (f, t), by_draw in sums.items():
        for e, w in np.ndindex(draws, ways):
            part, xi = by_draw[e][w], parameters[f, :, :, e, w]
            rms[f, :, :, t, e, w] = np.sqrt(part.squared_residual(xi))
            relative[f, :, :, t, e, w] = part.relative(xi)
    return rms, relative
