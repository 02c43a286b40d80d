"""The fit of a trial: least squares in which friction takes power from every joint, or none."""

import dataclasses

import cvxpy as cp
import numpy as np
import pytest

from oed.checkup.change import Change
from oed.checkup.trial import Trials, with_rotors
from tests.checkup.simulated_arm import dataset, model_of, processed

REVERSED = 2  # joint whose torque is logged with the other sign


def _rows(trials):
    """Columns with a constant of each joint, velocities and torques, all samples together."""
    none = Change.none(trials.model.robot.n)
    columns = np.concatenate([own for r in trials.recordings for _, own in trials._pieces(r, none)])
    n = columns.shape[1]
    constants = np.broadcast_to(np.eye(n), (len(columns), n, n))
    dq = np.concatenate([r.motion.dq for r in trials.recordings])
    tau = np.concatenate([r.tau for r in trials.recordings])
    return np.concatenate([columns, constants], axis=2), dq, tau


def _trials(sign):
    gain = np.where(np.arange(3) == REVERSED, sign, 1.0)
    data = dataset(lambda recording: dataclasses.replace(recording, tau=recording.tau * gain))
    logs = tuple(r for group in processed(data).values() for r in group)
    return Trials(with_rotors(model_of(data.robot)), logs)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_friction_drives_no_joint_and_nothing_else_is_asked(sign):
    trials = _trials(sign)
    columns, dq, tau = _rows(trials)
    names = [p.name for p in trials.model.parameters]
    friction = np.array([name[:2] in ("Fc", "Fv") for name in names] + [False] * 3)
    outcome = trials.as_logged
    power = np.einsum("njp,nj,p->j", columns[:, :, friction], dq, outcome.parameters[friction])
    assert (power > -1e-6 * np.abs(power).max()).all()
    # The same by a general solver, rows weighted by what the fit leaves.
    left = tau - columns @ outcome.parameters
    weights = 1 / np.sqrt(np.mean(left**2, axis=0))
    x = cp.Variable(columns.shape[2])
    norms = np.sqrt(np.sum(columns**2, axis=(0, 1))) + 1e-12
    taken = np.einsum("njp,nj->jp", columns * friction, dq) / norms
    rows = (columns * weights[:, None] / norms).reshape(-1, len(norms))
    Q, R = np.linalg.qr(rows)
    goal = cp.sum_squares(R @ x - Q.T @ (tau * weights).ravel())
    cp.Problem(cp.Minimize(goal), [taken @ x >= 0]).solve(solver="CLARABEL")
    best = tau - columns @ (x.value / norms)
    told = [float(np.sum((r * weights) ** 2)) for r in (left, best)]
    assert told[0] == pytest.approx(told[1], rel=1e-3)
    if sign < 0:
        assert power[REVERSED] < 1e-3 * power.max()
