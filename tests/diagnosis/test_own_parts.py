"""What is part of an effect: a ripple's mean, a gear's rotor; and what is not."""

import numpy as np
import pytest

from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.evidence.estimates import Estimated
from oed.diagnosis.evidence.own_parts import UNEVEN, with_own_parts
from oed.diagnosis.evidence.verdict import FoundEffect
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of, trial_of

AMPLITUDE, WAVES, PHASE, UNEVENNESS = 3.0, 12.0, 1.4, 0.4  # [N m], a turn, [rad], [rad]


def _uneven(x):
    return AMPLITUDE * np.sin(x + PHASE + UNEVENNESS * np.sin(x))


def _diagnosed(offset: float):
    def uneven(q, dq, ddq):
        wave = _uneven(WAVES * q[:, 0]) + offset
        return np.stack([wave, 0 * wave], axis=1)

    data = data_set(3, extra=uneven)
    candidates = ("torque_ripple", "torque_offset", "joint_spring", "asymmetric_viscous")
    settings = DiagnosisSettings(surrogates=39, refined=4, bootstrap=20, candidates=candidates)
    return diagnose(data, TorqueModel.standard(data.robot), settings)


def test_the_mean_of_an_uneven_ripple_is_its_own():
    x = np.linspace(0, 2 * np.pi, 1001)[:-1]
    expected = _uneven(x).mean()
    found = _diagnosed(0.0)
    (ripple,) = found.effects
    assert (found.verdict, ripple.name, ripple.joint) == ("explained", "torque_ripple", 0)
    (mean,) = (p for p in ripple.parameters if p.name == "ripple_mean_1")
    # Five deviations, and what two waves leave of the third and higher ones.
    assert mean.value == pytest.approx(expected, abs=5 * mean.std + 0.01)
    assert all(n not in ("torque_offset", "joint_spring") for n in (e.name for e in found.effects))


def test_a_larger_constant_beside_it_is_an_offset():
    found = _diagnosed(2 * UNEVEN * AMPLITUDE)
    assert {e.name for e in found.effects} == {"torque_ripple", "torque_offset"}
    ripple = next(e for e in found.effects if e.name == "torque_ripple")
    assert not [p for p in ripple.parameters if p.name.startswith("ripple_mean")]


def _effect(shop, name, joint, value):
    parameters = (Estimated(f"{name}_1", value, 0.1 * value, "1"),)
    trial = trial_of(shop, name, joint)
    return FoundEffect(name, joint, parameters, 1e-9, 0.1, (), trial)


@pytest.mark.parametrize("gear", ["backlash", "joint_elasticity"])
def test_the_rotor_of_a_gear_is_its_own(gear):
    shop = shop_of(data_set(5))
    found = [_effect(shop, "rotor_inertia", 0, 0.2), _effect(shop, gear, 0, 1.0)]
    (only,) = with_own_parts(found)
    assert (only.name, only.joint) == (gear, 0)
    assert (only.parameters[0].name, only.parameters[0].value) == ("geared_rotor_1", 0.2)
    # That of another joint, and one beside anything else, is an effect as it was.
    other = [_effect(shop, "rotor_inertia", 1, 0.2), _effect(shop, gear, 0, 1.0)]
    assert list(with_own_parts(other)) == other
    plain = [_effect(shop, "rotor_inertia", 0, 0.2), _effect(shop, "stribeck", 0, 1.0)]
    assert list(with_own_parts(plain)) == plain
