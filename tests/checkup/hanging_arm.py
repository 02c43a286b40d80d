"""Links that hang in a vertical plane, with friction and rotors, recorded on known motions."""

import numpy as np

from oed.dynamics.models import build_model
from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording
from oed.robot import JointLimits, Robot
from oed.robot.inertia import parameters_from_pseudo_inertia
from tests.checkup.simulated_arm import hinge, sines

ADDED = {"Fc": 0.5, "Fv": 0.8, "Ia": 0.05}  # of each joint [N m], [N m s/rad], [kg m^2]
NOISE = 0.02  # [N m]
LENGTHS = (0.3, 0.25)  # [m] of the links
MASS = 0.6  # [kg] of each


def hanging(links: int = 2) -> Robot:
    """Links of which gravity tells the direction by their coupling alone: of one it tells none."""
    axis, hinges = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -LENGTHS[0]])
    joints = tuple(hinge(i, axis, i * hinges) for i in range(links))
    bodies = np.concatenate([_rod(length) for length in LENGTHS[:links]])
    gravity = np.array([0.0, 0.0, -9.81])
    return Robot("hanging links", joints, bodies, gravity, JointLimits.unlimited(links))


def _rod(length):
    pseudo = MASS * np.diag([1e-4, 1e-4, length**2 / 3, 1.0])
    pseudo[2, 3] = pseudo[3, 2] = -MASS * length / 2
    return parameters_from_pseudo_inertia(pseudo)


def data_set(seed, links=2):
    rng, robot = np.random.default_rng(seed), hanging(links)
    model = build_model("rotor", robot, sign_width=0.02)
    added = [ADDED[p.name[:2]] for p in model.parameters[len(robot.parameters) :]]
    recordings = []
    for role, seconds in (("estimation", 15.0), ("validation", 7.0)):
        t = np.arange(0.0, seconds, 0.005)
        motion = sines(rng, t, links, 0.5, 0.4)
        tau = model.torque(np.array([*robot.parameters, *added]), motion)
        tau += NOISE * rng.standard_normal(tau.shape)
        recordings.append(Recording(role, role, t, motion.q, tau))
    return DataSet("hanging", "tests", "none", robot, "measured", recordings=tuple(recordings))
