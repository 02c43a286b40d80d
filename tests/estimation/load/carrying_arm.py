"""A six-joint arm with a body welded to its flange, its torques by Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.estimation.load.quantities import Quantity
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.processed import ProcessedRecording, processed
from oed.experiment.preparation.settings import choose_settings
from oed.experiment.recording import Recording
from oed.robot import load_robot
from oed.robot.attached_frame import find_frame
from tests.paths import example_robot

UR5 = example_robot("ur_description/urdf/ur5_robot.urdf")
ROBOT = load_robot(UR5)
FRAME = find_frame(ROBOT)
MODEL = build_model("standard", ROBOT, sign_width=0.02)
RATE = 125.0  # [Hz]
CUTOFF = 5.0  # [Hz]
COULOMB = np.array([9.0, 10.0, 6.0, 1.6, 1.5, 1.2])
VISCOUS = np.array([11.0, 12.0, 8.0, 1.8, 1.6, 1.3])
NOISE = np.array([0.8, 0.9, 0.6, 0.15, 0.12, 0.1])  # [N m]
MASS, CENTRE = 2.0, np.array([0.02, -0.01, 0.06])
CENTRAL = np.array([[0.006, 0.001, 0.0], [0.001, 0.005, -0.0005], [0.0, -0.0005, 0.004]])
RANGE = np.array([1.5, 0.9, 1.5, 1.8, 1.8, 2.5])  # [rad] about the middle
MIDDLE = np.array([0.0, -1.4, 0.6, -0.5, 0.4, 0.0])
SPEED = np.array([1.2, 1.0, 1.2, 2.0, 2.0, 3.0])  # [rad/s]


def sweep(rng, seconds):
    """Three sines a joint."""
    t = np.arange(0.0, seconds, 1 / RATE)
    omega = 2 * np.pi * rng.uniform(0.1, 0.8, (6, 3))
    amplitude = rng.uniform(0.4, 1.0, (6, 3))
    amplitude *= (np.minimum(RANGE / amplitude.sum(1), SPEED / (amplitude * omega).sum(1)))[:, None]
    phase = t[:, None, None] * omega + rng.uniform(0, 2 * np.pi, (6, 3))
    return Motion(
        t,
        MIDDLE + np.sum(amplitude * np.sin(phase), axis=2),
        np.sum(amplitude * omega * np.cos(phase), axis=2),
        np.sum(-amplitude * omega**2 * np.sin(phase), axis=2),
    )


def known_interval(quantity: Quantity) -> tuple[float, float]:
    """Of a quantity that the data determine."""
    assert quantity.interval is not None
    return quantity.interval


def torque(motion, *, is_loaded, load_friction=0.0, at="tool0"):
    """Of the arm and the body by Pinocchio, with friction [N m]."""
    model = pin.buildModelFromUrdf(str(UR5))
    if is_loaded:
        flange = model.frames[model.getFrameId(at)]
        body = pin.Inertia(MASS, CENTRE, CENTRAL)
        model.appendBodyToJoint(flange.parentJoint, body, flange.placement)
    data = model.createData()
    rigid = np.array(
        [pin.rnea(model, data, *x) for x in zip(motion.q, motion.dq, motion.ddq, strict=True)]
    )
    sign = np.tanh(motion.dq / 0.02)
    return rigid + COULOMB * sign + VISCOUS * motion.dq + load_friction * np.abs(rigid) * sign


def recording(rng, seconds, *, noise=1.0, **more) -> ProcessedRecording:
    """A processed log."""
    motion = sweep(rng, seconds)
    tau = torque(motion, **more) + noise * NOISE * rng.standard_normal(motion.q.shape)
    logs = (Recording("log", "estimation", motion.t, motion.q, tau),)
    return processed(prepare(logs, choose_settings(logs, cutoff=CUTOFF))[0])[0]
