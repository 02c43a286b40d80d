"""A shape whose score has crests between the values of a first scan is scanned once more."""

import dataclasses

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from oed.diagnosis.evidence.views import Views
from oed.diagnosis.selection.screen import evaluate, polish
from oed.diagnosis.setup import pose
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set

PICKED_UP = 17.3  # [s] in four repetitions of ten seconds


def _loaded():
    """A load of half a kilogram at the last link, from one moment on."""
    dataset = data_set(71, repetitions=4, roles=("estimation", "validation"))
    robot, first = dataset.robot, dataset.recordings[0]
    change = np.zeros_like(robot.parameters)
    change[-10:] = [0.5, 0.5 * 0.3, 0, 0, 0, 0, 0, 0, 0, 0.5 * 0.09]
    path = CubicSpline(first.t, first.q)
    motion = Motion(first.t, first.q, path(first.t, 1), path(first.t, 2))
    rows = TorqueModel.standard(robot).regressor(motion)[:, : len(change)]
    load = (rows @ change).reshape(first.q.shape)
    later = first.t - first.t[0] > PICKED_UP
    carrying = dataclasses.replace(first, tau=first.tau + load * later[:, None])
    return dataclasses.replace(dataset, recordings=(carrying, dataset.recordings[1]))


def test_the_moment_of_a_load_is_found_between_those_of_the_first_scan():
    dataset = _loaded()
    problem = pose(dataset, TorqueModel.standard(dataset.robot), names=("payload_change",))[0]
    fitted = Views.of(problem, (), "fitted").every
    (law,) = problem.names
    tried = (evaluate(law, values, fitted) for values in law.grid(problem.context))
    start = max((s for s in tried if s is not None), key=lambda s: s.nats)
    assert abs(start.values[0] - PICKED_UP) > 0.2
    assert polish(start, fitted).values[0] == pytest.approx(PICKED_UP, abs=0.1)
