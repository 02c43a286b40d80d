"""One experiment as the paper shows it: its figures 4 to 6, 8, 10 and 11."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.estimation.recursive import recursive_least_squares
from oed.estimation.weights import variances_from_repetitions
from oed.experiment.paper_signals import sample_runs
from studies.paper_experiment.laboratory import JOINTS, PERIOD, SHOWN, Bench, LaboratoryConfig


@dataclass(frozen=True)
class Shown:
    """One design on the arm with rich friction, processed as in the paper.

    Attributes:
        recursion: (steps, 8) xi-hat after each sample.
        recursion_std: (steps, 8) square roots of diag P.
        torque: (3, rows, n) measured in the estimation, validation and test set [N m].
        predicted: (3, rows, n) [N m].
    """

    recursion: Float[ndarray, "steps 8"]
    recursion_std: Float[ndarray, "steps 8"]
    torque: Float[ndarray, "3 rows n"]
    predicted: Float[ndarray, "3 rows n"]


def show(
    config: LaboratoryConfig, bench: Bench, reference: Motion, test: Motion, kind: int
) -> Shown:
    """Recursive estimate and validation, as in sections 4 and 5."""
    M = config.repetitions
    logs = (
        bench.record(config, "rich", motion, (SHOWN, kind, k), config.variance_repetitions)
        for k, motion in enumerate((reference, test))
    )
    runs, tests = (sample_runs(log, PERIOD, config.samples, "online") for log in logs)
    sets = (runs.of(slice(M)), runs.of(slice(M, 2 * M)), tests.of(slice(M)))
    estimate = recursive_least_squares(
        sets[0].regressor,
        sets[0].tau.ravel(),
        JOINTS,
        noise=variances_from_repetitions(runs.raw),
        block=JOINTS,
    )
    xi = estimate.solution.parameters
    return Shown(
        estimate.parameters,
        estimate.std,
        np.stack([s.tau.reshape(-1, JOINTS) for s in sets]),
        np.stack([(s.columns @ xi).reshape(-1, JOINTS) for s in sets]),
    )
