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
        hinge(i, np.array([0.0, 0.0, 1.0]), position, rotation)
        for i, (rotation, position) in enumerate(frames)
    )
    return Robot(
        name="arm",
        joints=joints,
        parameters=np.concatenate([_rod(4.0), _rod(3.0), _rod(2.0)]),
        gravity=np.array(gravity),
        limits=JointLimits.unlimited(3),
    )


def hinge(number, axis, position, rotation=None):
    """The joint after that of a chain with the number before it."""
    return Joint(
        name=f"joint_{number + 1}",
        kind="revolute",
        parent=number - 1,
        axis=axis,
        R_PJ=np.eye(3) if rotation is None else rotation,
        p_PJ=position,
        link=f"link_{number + 1}",
        R_LJ=np.eye(3),
        p_LJ=np.zeros(3),
    )


def sines(rng, t, joints, fastest, widest):
    """Four sines a joint, of 0.1 Hz to the fastest and of 0.1 rad to the widest."""
    w, a = 2 * np.pi * rng.uniform(0.1, fastest, (joints, 4)), rng.uniform(0.1, widest, (joints, 4))
    phase = t[:, None, None] * w + rng.uniform(0, 2 * np.pi, (joints, 4))
    return Motion(
        t,
        (a * np.sin(phase)).sum(2),
        (a * w * np.cos(phase)).sum(2),
        (-a * w**2 * np.sin(phase)).sum(2),
    )


def processed(data):
    return process_all(data, choose_settings(data.recordings))


def model_of(robot):
    return build_model("standard", robot, sign_width=0.05)


def recorded(seed, role, name, seconds=12.0, gravity=(0.0, 0.0, -9.81)):
    """A motion of sines and the torque that it takes, with noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1 / RATE)
    motion = sines(rng, t, 3, 0.8, 0.35)
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
