"""A two-joint arm in a vertical plane and what it holds, as data sets."""

from __future__ import annotations

import dataclasses

import numpy as np

from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording
from oed.experiment.write_dataset import write_dataset
from oed.robot import load_robot

ROBOT = load_robot("builtin:imi_scara", gravity=(0.0, -9.81, 0.0))
MODEL = build_model("standard", ROBOT, sign_width=0.02)
FRICTION = (3.0, 1.6, 1.2, 0.6)
MASS, CENTRE = 1.5, np.array([0.05, -0.02, 0.0])


def data(rng, seconds, load, *, name):
    t = np.arange(0.0, seconds, 0.008)
    omega = 2 * np.pi * rng.uniform(0.15, 0.9, (2, 3))
    a = np.array([[0.5], [0.6]]) * rng.uniform(0.5, 1.0, (2, 3))
    phase = t[:, None, None] * omega + rng.uniform(0, 6, (2, 3))
    q, dq, ddq = (
        (a * np.sin(phase)).sum(2),
        (a * omega * np.cos(phase)).sum(2),
        -(a * omega**2 * np.sin(phase)).sum(2),
    )
    truth = np.concatenate([ROBOT.parameters, FRICTION])
    truth[10:20] += load
    tau = MODEL.torque(truth, Motion(t, q, dq, ddq)) + 0.05 * rng.standard_normal(q.shape)
    recording = Recording(name, "estimation", t, q, tau)
    return DataSet(name, "made by a test", "CC0", ROBOT, "measured", recordings=(recording,))


def load_parameters():
    """Of the body that it holds, about the last link's frame."""
    shift = MASS * (CENTRE @ CENTRE * np.eye(3) - np.outer(CENTRE, CENTRE))
    inertia = (0.004 * np.eye(3) + shift)[np.triu_indices(3)]
    return np.array([MASS, *(MASS * CENTRE), *inertia])


def write_sets(home):
    """Folders `bare` and `loaded`."""
    rng = np.random.default_rng(4)
    load = load_parameters()
    write_dataset(data(rng, 24.0, 0 * load, name="bare"), home / "bare")
    write_dataset(data(rng, 12.0, load, name="loaded"), home / "loaded")


def write_in_amperes(home, gains):
    """The same with currents in place of torques, and nothing said of constants."""
    rng = np.random.default_rng(5)
    for name, seconds, share in (("bare", 24.0, 0.0), ("loaded", 12.0, 1.0)):
        whole = data(rng, seconds, share * load_parameters(), name=name)
        (log,) = whole.recordings
        currents = dataclasses.replace(log, tau=log.tau / gains)
        write_dataset(
            dataclasses.replace(
                whole, robot=whole.robot.with_amperes(), torque="current", recordings=(currents,)
            ),
            home / name,
        )
