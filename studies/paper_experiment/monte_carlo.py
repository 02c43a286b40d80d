"""The paper's experiment made hundreds of times: what holds beyond one draw of the noise."""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.estimation.weights import variances_from_repetitions
from oed.experiment.imi_laboratory import Friction
from oed.experiment.paper_signals import Processing, SampledRuns, sample_runs
from oed.experiment.simulation import run
from oed.process_end import end_with_parent
from oed.report.progress import progress
from oed.robot.builtin import IMI_LINK_LENGTHS
from studies.paper_experiment.campaign import FRICTIONS, JOINTS, SETS, XI, Bench, CampaignConfig
from studies.paper_experiment.designs import NAMES, DesignSet

TEST = NAMES.index("test")
DESIGNS = tuple(range(4))  # the harmonic designs: GA and exact limits, J_k and J_d
MEASURED = ("parameters", "predicted", "variances", "rms", "relative")
# Runs simulated side by side: as many as fit the memory comfortably.
RUNS_AT_ONCE = 240


@dataclass(frozen=True)
class MonteCarlo:
    """E experiments a cell: friction F, design D, processing R.

    Attributes:
        processings: (R,) names.
        parameters: (F, D, R, E, 8) xi-hat.
        predicted: (F, D, R, E, 8) diagonal of P (8).
        variances: (F, D, R, E, n) by the paper's formula [N^2 m^2].
        rms: (F, D, R, E, 3, n) residual on the sets of `SETS` [N m].
        relative: (F, D, R, E, 3, n) the same over the rms torque.
    """

    processings: ndarray
    parameters: Float[ndarray, "F D R E 8"]
    predicted: Float[ndarray, "F D R E 8"]
    variances: Float[ndarray, "F D R E n"]
    rms: Float[ndarray, "F D R E 3 n"]
    relative: Float[ndarray, "F D R E 3 n"]


@dataclass(frozen=True)
class _Piece:
    """What one process works on: some experiments of one friction, all designs."""

    config: CampaignConfig
    bench: Bench
    processings: tuple[Processing, ...]
    references: tuple[Motion, ...]
    test: Motion
    friction: Friction
    first: int
    count: int


def run_monte_carlo(
    config: CampaignConfig,
    bench: Bench,
    designs: DesignSet,
    processings: tuple[Processing, ...],
    *,
    experiments: int,
    workers: int,
) -> MonteCarlo:
    """All cells; the same experiment number has the same noise in every design's test set."""
    period = 0.001
    references = tuple(designs.motion(d, period) for d in DESIGNS)
    test = designs.motion(TEST, period)
    size = max(1, RUNS_AT_ONCE // (2 * config.repetitions))
    pieces = [
        _Piece(
            config,
            bench,
            processings,
            references,
            test,
            friction,
            first,
            min(size, experiments - first),
        )
        for friction in FRICTIONS
        for first in range(0, experiments, size)
    ]
    shape = (len(FRICTIONS), len(DESIGNS), len(processings), experiments)
    result = MonteCarlo(
        np.array(processings),
        np.empty((*shape, XI)),
        np.empty((*shape, XI)),
        np.empty((*shape, JOINTS)),
        np.empty((*shape, len(SETS), JOINTS)),
        np.empty((*shape, len(SETS), JOINTS)),
    )
    if workers > 1:
        with ProcessPoolExecutor(
            workers, initializer=end_with_parent, initargs=(os.getpid(),)
        ) as pool:
            found = pool.map(_work, pieces)
            done = list(progress(found, "experiments", total=len(pieces)))
    else:
        done = [_work(piece) for piece in progress(pieces, "experiments")]
    for piece, arrays in zip(pieces, done, strict=True):
        f = FRICTIONS.index(piece.friction)
        where = slice(piece.first, piece.first + piece.count)
        for name, values in zip(MEASURED, arrays, strict=True):
            getattr(result, name)[f, :, :, where] = values
    return result


def infeasible(parameters: Float[ndarray, "*cells 8"]) -> Bool[ndarray, "*cells"]:
    """Whether no arm of positive masses and no friction that dissipates has these parameters.

    Some m_2 > 0 must give the first link an inertia Gamma_1z > 0 and the second a centre of
    mass within its inertia, |m_2 s_2|^2 < m_2 Gamma_2z: together l_1^2 |m_2 s_2|^2 < Gamma_2z
    (Gamma_1z + m_2 l_1^2).
    """
    total, x, y, second = np.moveaxis(parameters[..., :4], -1, 0)
    room = second * total - IMI_LINK_LENGTHS[0] ** 2 * (x**2 + y**2)
    friction = parameters[..., 4:].min(axis=-1)
    return (total <= 0) | (second <= 0) | (room <= 0) | (friction < 0)


def _work(piece: _Piece) -> tuple[ndarray, ...]:
    """(D, R, e, ...) arrays in the order of `MEASURED`."""
    config, M = piece.config, piece.config.repetitions
    setup = piece.bench.setup(config, piece.friction)
    period = setup.controller.period
    seed = [config.seed, 1000 + FRICTIONS.index(piece.friction), piece.first]
    log = run(setup, piece.test, np.random.default_rng([*seed, TEST]), runs=piece.count * M)
    tests = [sample_runs(log, period, config.samples, p) for p in piece.processings]
    cells = []
    for design, reference in enumerate(piece.references):
        rng = np.random.default_rng([*seed, design])
        log = run(setup, reference, rng, runs=piece.count * 2 * M)
        by_processing = []
        for test, processing in zip(tests, piece.processings, strict=True):
            runs = sample_runs(log, period, config.samples, processing)
            by_processing.append([_experiment(runs, test, M, e) for e in range(piece.count)])
        cells.append(by_processing)
    return tuple(
        np.array([[[one[i] for one in many] for many in cell] for cell in cells]) for i in range(5)
    )


def _experiment(
    runs: SampledRuns, test: SampledRuns, M: int, e: int
) -> tuple[ndarray, ndarray, ndarray, ndarray, ndarray]:
    start = 2 * M * e
    sets = (
        runs.of(slice(start, start + M)),
        runs.of(slice(start + M, start + 2 * M)),
        test.of(slice(e * M, (e + 1) * M)),
    )
    variances = variances_from_repetitions(runs.raw[start : start + 2 * M])
    weight = np.tile(1 / np.sqrt(variances), len(sets[0].tau.ravel()) // JOINTS)
    white = sets[0].regressor * weight[:, None]
    # Well conditioned by design, cond Lambda of tens to hundreds: normal equations do.
    information = white.T @ white
    parameters = np.linalg.solve(information, white.T @ (sets[0].tau.ravel() * weight))
    rms, relative = [], []
    for part in sets:
        residual = part.tau - part.columns @ parameters
        rms.append(np.sqrt((residual**2).mean(axis=(0, 1))))
        relative.append(rms[-1] / np.sqrt((part.tau**2).mean(axis=(0, 1))))
    predicted = np.diag(np.linalg.inv(information))
    return parameters, predicted, variances, np.array(rms), np.array(relative)
