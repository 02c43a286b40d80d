"""A three-joint arm with known parameters, recorded on known motions, and spoilt as asked."""

import dataclasses

import numpy as np

from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.estimation.stacking import process_all
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.settings import choose_settings
from oed.experiment.recording import Recording
from oed.experiment.stretches import split_at_gaps
from oed.robot import Joint, JointLimits, Robot
from oed.robot.inertia import parameters_from_pseudo_inertia

RATE = 200.0
NOISE = 0.05  # [N m]


def arm(gravity=(0.0, 0.0, -9.81)):
    """A base that turns about the vertical, a shoulder and an elbow that lift 0.4 m links."""
    lift = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    frames = ((np.eye(3), np.zeros(3)), (lift, np.zeros(3)), (np.eye(3), np.array([0.4, 0, 0])))
    joints = tuple(
        Joint(
            name=f"joint_{i + 1}",
            kind="revolute",
            parent=i - 1,
            axis=np.array([0.0, 0.0, 1.0]),
            R_PJ=R,
            p_PJ=p,
            link=f"link_{i + 1}",
            R_LJ=np.eye(3),
            p_LJ=np.zeros(3),
        )
        for i, (R, p) in enumerate(frames)
    )
    return Robot(
        name="arm",
        joints=joints,
        parameters=np.concatenate([_rod(4.0), _rod(3.0), _rod(2.0)]),
        gravity=np.array(gravity),
        limits=JointLimits.unlimited(3),
    )


def processed(data):
    return process_all(data, choose_settings(data.recordings))


def model_of(robot):
    return build_model("standard", robot, sign_width=0.05)


def recorded(seed, role, name, seconds=12.0, gravity=(0.0, 0.0, -9.81)):
    """A motion of sines and the torque that it takes, with noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1 / RATE)
    w, a = 2 * np.pi * rng.uniform(0.1, 0.8, (3, 4)), rng.uniform(0.1, 0.35, (3, 4))
    phase = t[:, None, None] * w + rng.uniform(0, 2 * np.pi, (3, 4))
    motion = Motion(
        t,
        (a * np.sin(phase)).sum(2),
        (a * w * np.cos(phase)).sum(2),
        (-a * w**2 * np.sin(phase)).sum(2),
    )
    model = model_of(arm(gravity))
    truth = np.concatenate([model.robot.parameters, [1.0, 2.0, 1.5, 2.5, 0.8, 1.2]])
    torque = model.torque(truth, motion) + NOISE * rng.standard_normal(motion.q.shape)
    return Recording(name, role, motion.t, motion.q, torque)


def dataset(change=lambda recording: recording, gravity=(0.0, 0.0, -9.81), **given):
    recordings = given.get("recordings") or (
        recorded(1, "estimation", "fit"),
        recorded(2, "validation", "held"),
    )
    return split_at_gaps(
        DataSet(
            "simulated",
            "tests",
            "none",
            arm(gravity),
            "measured",
            recordings=tuple(change(recording) for recording in recordings),
        )
    )


def later(recording, seconds):
    """The recording with its torque logged later by some time."""
    tau = np.column_stack(
        [np.interp(recording.t - seconds, recording.t, column) for column in recording.tau.T]
    )
    return dataclasses.replace(recording, tau=tau)


def _rod(mass, length=0.4, radius=0.08):
    centre = np.array([length / 2, 0.0, 0.0])
    pseudo = np.empty((4, 4))
    spread = np.diag([length**2 / 12, radius**2 / 2, radius**2 / 2])
    pseudo[:3, :3] = mass * (spread + np.outer(centre, centre))
    pseudo[:3, 3] = pseudo[3, :3] = mass * centre
    pseudo[3, 3] = mass
    return parameters_from_pseudo_inertia(pseudo)
