"""What a drive adds to other joints, against torques written out."""

import numpy as np
import pytest

from oed.dynamics.effects.catalogue import CATALOGUE, Context, Drives
from oed.dynamics.effects.entry import evaluate
from oed.dynamics.effects.motor import CrossCoupling, MixedTorque
from oed.dynamics.newton_euler import rigid_body_torque
from oed.dynamics.torque_model import TorqueModel
from tests.dynamics.effects.arms import parameters_of, smooth_motion, vertical_arm

ARM = vertical_arm()
MOTION = smooth_motion(ARM)
MODEL = TorqueModel.standard(ARM)
ENTRY = CATALOGUE["motor_coupling"]
WHOLE = (0.0, 3.0)  # no ratio of speeds, the share of a torque


def context_with(*, of_motors: bool) -> Context:
    return Context.of(MODEL, parameters_of(MODEL), [MOTION], Drives(of_motors=of_motors))


def test_a_wrist_whose_coupling_is_not_undone_holds_a_share_of_the_other_torque() -> None:
    """Motor 2 turns with dq_2 + r dq_1: by virtual work motor 1 gives tau_1 - r tau_2."""
    ratio = 0.4
    effect = ENTRY.build(context_with(of_motors=True), (0, 1), WHOLE)
    assert isinstance(effect, MixedTorque)
    joints = rigid_body_torque(ARM, MOTION) + 2.0 * np.sign(MOTION.dq) + 1.0 * MOTION.dq
    jacobian = np.array([[1.0, 0.0], [ratio, 1.0]])  # of the motors' speeds by the joints'
    motors = joints @ np.linalg.inv(jacobian)  # power is the same in both
    column = evaluate(effect, MOTION, 2)[:, :, 0]
    assert joints - ratio * column == pytest.approx(motors, abs=1e-9)


@pytest.mark.parametrize(("of_motors", "highest"), [(True, 3.0), (False, 2.0)])
def test_torque_sensors_show_no_coupling_of_motors(of_motors: bool, highest: float) -> None:
    _, rows = ENTRY.shapes_for(context_with(of_motors=of_motors), (0, 1))
    assert rows.upper == max(rows.grid) == highest


@pytest.mark.parametrize(
    ("share", "fits"), [(0.3, True), (-1.0, True), (4.0, False), (-0.05, False)]
)
def test_no_gears_make_a_share_of_several_or_of_next_to_nothing(share: float, fits: bool) -> None:
    reason = ENTRY.plausible(context_with(of_motors=True), (0, 1), WHOLE, np.array([share]))
    assert (reason is None) is fits


@pytest.mark.parametrize("ratio", [0.0, 1.0])
@pytest.mark.parametrize(
    ("inertia", "viscous", "coulomb", "fits"),
    [(0.0, 1.0, 0.01, False), (0.0, 1.0, 0.5, True), (0.2, 1.0, 0.0, True)],
)
def test_a_motor_is_more_than_a_drag(ratio, inertia, viscous, coulomb, fits) -> None:
    estimates = np.array([inertia, viscous, coulomb])
    reason = ENTRY.plausible(context_with(of_motors=True), (0, 1), (ratio, 2.0), estimates)
    assert (reason is None) is fits


def test_rows_of_an_inertia_stay_what_they_were() -> None:
    context = context_with(of_motors=True)
    for rows, mutual in ((1.0, False), (2.0, True)):
        effect = ENTRY.build(context, (0, 1), (0.0, rows))
        assert isinstance(effect, CrossCoupling)
        assert effect.mutual is mutual


@pytest.mark.parametrize("kind", [CrossCoupling, MixedTorque])
def test_a_joint_is_not_coupled_to_itself(kind: type) -> None:
    reference = context_with(of_motors=True).reference
    rest = (reference,) if kind is MixedTorque else ()
    with pytest.raises(ValueError, match="coupled to itself"):
        kind(1, 1, *rest)
