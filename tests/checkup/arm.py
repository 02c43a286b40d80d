"""A three-joint arm, simulated under feedback, and its logs as they are and spoiled."""

import dataclasses

import numpy as np

from oed.dynamics.effects import Coulomb, Viscous
from oed.dynamics.motion import Motion
from oed.experiment.control import Controller
from oed.experiment.dataset import DataSet
from oed.experiment.disturbance import Disturbance
from oed.experiment.observer import HighGainObserver
from oed.experiment.plant import TruePlant
from oed.experiment.sensors import Sensors
from oed.experiment.simulation import Setup, simulate
from oed.robot import Joint, JointLimits, Robot
from oed.robot.inertia import parameters_from_pseudo_inertia

# A vertical axis, then a shoulder and an elbow of horizontal ones: twist [rad], origin [m],
# mass [kg], length and radius [m] of a cylinder along x.
LINKS = (
    (0.0, (0.0, 0.0, 0.1), 4.0, 0.15, 0.06),
    (np.pi / 2, (0.05, 0.0, 0.0), 6.0, 0.4, 0.05),
    (0.0, (0.4, 0.0, 0.0), 2.5, 0.35, 0.04),
)
COULOMB = (3.0, 4.0, 1.5)  # [N m]
VISCOUS = (4.0, 5.0, 2.0)  # [N m s/rad]
NOISE = Disturbance((0.2, 0.3, 0.1), (30.0, 30.0, 30.0))  # [N m], [rad/s]
LOGGED = 5  # one sample in that many: 200 Hz


def robot() -> Robot:
    joints, bodies = [], []
    for i, (twist, origin, mass, length, radius) in enumerate(LINKS):
        c, s = np.round(np.cos(twist)), np.round(np.sin(twist))
        rotation = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        joints.append(
            Joint(
                name=("base", "shoulder", "elbow")[i],
                kind="revolute",
                parent=i - 1,
                axis=np.array([0.0, 0.0, 1.0]),
                R_PJ=rotation,
                p_PJ=np.array(origin),
                link=f"link_{i + 1}",
                R_LJ=np.eye(3),
                p_LJ=np.zeros(3),
            )
        )
        bodies.append(_cylinder(mass, length, radius))
    limits = JointLimits.symmetric(
        position=(3.0,) * 3, velocity=(4.0,) * 3, acceleration=(15.0,) * 3
    )
    gravity = np.array([0.0, 0.0, -9.81])
    return Robot("three-joint arm", tuple(joints), np.concatenate(bodies), gravity, limits)


def _cylinder(mass, length, radius):
    centre = np.array([length / 2, 0.1 * radius, 0.2 * radius])
    spread = np.diag([length**2 / 12, radius**2 / 4, radius**2 / 4])
    pseudo = np.empty((4, 4))
    pseudo[:3, :3] = mass * (spread + np.outer(centre, centre))
    pseudo[:3, 3] = pseudo[3, :3] = mass * centre
    pseudo[3, 3] = mass
    return parameters_from_pseudo_inertia(pseudo)


def placeholder(arm: Robot) -> Robot:
    """The same kinematics with balls of one kilogram at the joints' axes, as files often have."""
    ball = np.diag([0.01, 0.01, 0.01, 1.0])
    ball[:3, 3] = ball[3, :3] = 0.1, 0.0, 0.0
    return arm.with_parameters(np.tile(parameters_from_pseudo_inertia(ball), arm.n))


def data_set(rng, *, seconds=(20.0, 10.0), reach=(1.0, 1.0, 1.0)):
    """One recording for estimation, within `reach` of its usual size, and one for validation."""
    arm = robot()
    effects = [e for j in range(3) for e in (Coulomb(j, 0.02), Viscous(j))]
    friction = [x for pair in zip(COULOMB, VISCOUS, strict=True) for x in pair]
    plant = TruePlant(arm, tuple(effects), tuple(friction))
    controller = Controller((600.0, 600.0, 100.0), (40.0, 40.0, 5.0), HighGainObserver.uniform(3))
    setup = Setup(plant, controller, Sensors(resolution=(1e-5,) * 3), NOISE)
    roles = ("estimation", "validation")
    recordings = []
    for role, length, size in zip(roles, seconds, (np.array(reach), np.ones(3)), strict=True):
        motion = _motion(rng, length, size)
        log = simulate(setup, motion, rng, name=role, role=role)
        thinned = (slice(None, None, LOGGED),)
        recordings.append(
            dataclasses.replace(log, t=log.t[thinned], q=log.q[thinned], tau=log.tau[thinned])
        )
    return DataSet("simulated", "tests", "none", arm, "measured", recordings=tuple(recordings))


def _motion(rng, seconds, size):
    t = np.arange(0.0, seconds, 0.001)
    rate = 2 * np.pi * rng.uniform(0.1, 0.5, (3, 4))
    amplitude = rng.uniform(0.15, 0.35, (3, 4)) * size[:, None]
    phase = t[:, None, None] * rate + rng.uniform(0, 2 * np.pi, (3, 4))
    return Motion(
        t,
        (amplitude * np.sin(phase)).sum(2),
        (amplitude * rate * np.cos(phase)).sum(2),
        -(amplitude * rate**2 * np.sin(phase)).sum(2),
    )


def changed(dataset, **change):
    """The data set with functions applied to fields of its recordings, as tau=lambda tau: -tau."""
    return dataclasses.replace(
        dataset,
        recordings=tuple(
            dataclasses.replace(r, **{field: f(getattr(r, field)) for field, f in change.items()})
            for r in dataset.recordings
        ),
    )


def with_robot(dataset, arm):
    return dataclasses.replace(dataset, robot=arm)
