"""The estimators of this package on a log, as its commands call them."""

from __future__ import annotations

import numpy as np

from oed.commands.from_data_set import Prepared, prepare
from oed.commands.identify import estimate
from oed.commands.telling import speak
from oed.estimation.feasible.calibration import FeasibleSettings, calibrate_feasibly
from oed.estimation.feasible.feasible_set import FeasibleSet
from oed.estimation.feasible.reference import file_inertials
from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording
from studies.estimators.arms import arm_of
from studies.estimators.conditions import Logs
from studies.estimators.recipe import Found


def _prepared(key: str, logs: Logs, draw: int) -> Prepared:
    speak(quiet=True)
    recording = Recording("log", "estimation", logs.t, logs.q[draw], logs.tau[draw])
    robot = arm_of(key).file
    dataset = DataSet(key, "simulated", "none", robot, "measured", recordings=(recording,))
    return prepare(dataset, model="standard")


def plain(key: str, logs: Logs, draw: int) -> Found:
    """`oed identify`: weighted least squares, intervals by HAC."""
    return _identified(key, logs, draw, robust=False)


def huber(key: str, logs: Logs, draw: int) -> Found:
    """`oed identify --robust`."""
    return _identified(key, logs, draw, robust=True)


def _identified(key: str, logs: Logs, draw: int, *, robust: bool) -> Found:
    base = arm_of(key).base
    calibration = estimate(_prepared(key, logs, draw), robust=robust)
    own = calibration.estimate
    columns = [
        int(np.flatnonzero(base.columns == calibration.base.columns[c])[0]) for c in own.columns
    ]
    found = Found.bare(np.zeros(len(base)))
    found.parameters[columns] = own.parameters
    # Combinations of columns have intervals of their own, which no parameter's truth stands beside.
    if own.status == "determined":
        quoted = [name not in own.unidentifiable for name in own.names]
        found.interval[columns] = np.where(np.array(quoted)[:, None], own.interval(), np.nan)
    return found


def feasible(key: str, logs: Logs, draw: int) -> Found:
    """`oed feasible`, pulled to neutral bodies."""
    return _feasible(key, logs, draw, wanted=False)


def feasible_prior(key: str, logs: Logs, draw: int) -> Found:
    """`oed feasible`, pulled to the file's bodies, which are 10 % off."""
    return _feasible(key, logs, draw, wanted=True)


def _feasible(key: str, logs: Logs, draw: int, *, wanted: bool) -> Found:
    prepared = _prepared(key, logs, draw)
    calibration = estimate(prepared, robust=False)
    settings = FeasibleSettings(
        demands=FeasibleSet.of(prepared.model),
        inertials=file_inertials(prepared.model.robot, wanted=wanted),
        resamples=2,
        poses=100,
    )
    result = calibrate_feasibly(calibration, settings)
    return Found.bare(arm_of(key).base.from_standard(result.estimate.parameters))
