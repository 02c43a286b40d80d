"""The bound on J_k, against the least condition number of an arm of one joint, which is known."""

import numpy as np
import pytest

from oed.design.bound.branch_and_bound import prove_maximum
from oed.design.bound.condition_bound import (
    ConditionNotBounded,
    ConditionSettings,
    _Space,
    condition_bound,
)
from oed.design.bound.states import ViableStates
from oed.dynamics.effects import Coulomb, TorqueOffset, Viscous
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.robot import imi_scara

QUICK = ConditionSettings(first_states=300, searched=3000)


def model_of(*effects):
    model = TorqueModel(imi_scara(), effects)
    return model, base_parameters(model)


def test_dry_and_viscous_friction_of_a_joint_are_told_apart_no_better_than_by_standing_and_racing():
    model, base = model_of(Coulomb(0), Viscous(0))
    limits = model.robot.limits
    # A mixture of the slowest and the fastest state: of all with one mean of v^2 the least mean |v|.
    V = ViableStates(limits).fastest[0]
    share = np.linspace(1e-3, 1.0, 20_001)[:-1]
    mixtures = np.moveaxis(np.array([[share**0, share * V], [share * V, share * V**2]]), -1, 0)
    least = np.linalg.cond(mixtures).min()
    found = condition_bound(model, base, limits, np.random.default_rng(0), QUICK)
    assert found.sampled == pytest.approx(least, rel=2e-3)
    assert found.J_k == pytest.approx((1 - QUICK.margin) * found.sampled)
    assert found.J_k <= least
    assert min(np.linalg.eigvalsh(x)[0] for x in (found.A, found.B)) >= -1e-12
    assert np.trace(found.A) / np.trace(found.B) == pytest.approx(found.J_k)


def test_a_joint_at_rest_is_looked_at_as_well():
    model, base = model_of(Coulomb(0), TorqueOffset(0))
    space = _Space(model, base, ViableStates(model.robot.limits))
    form = np.diag([1.0, -1.0])  # 0 wherever the joint moves, -1 where its sign is zero
    proof = prove_maximum(space.shortfall(form), space.boxes())
    assert proof.upper == pytest.approx(1.0)


def test_no_bound_is_claimed_without_a_certificate():
    model, base = model_of(Coulomb(0), Viscous(0))
    hardly = ConditionSettings(first_states=4, searched=100, rounds=1, margin=0.0)
    with pytest.raises(ConditionNotBounded, match="no certificate held after 1"):
        condition_bound(model, base, model.robot.limits, np.random.default_rng(0), hardly)
