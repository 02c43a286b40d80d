"""An effect of a user's own is fitted and named as those of the catalogue are."""

import dataclasses

import numpy as np
import pytest

from oed.diagnosis.diagnose import diagnose
from oed.dynamics.effects import Effect, Parameter
from oed.dynamics.effects.catalogue import (
    _ENTRIES,
    CATALOGUE,
    EffectPage,
    Shape,
    named_effect,
    register,
)
from oed.dynamics.torque_model import TorqueModel
from tests.diagnosis.arm import data_set


@dataclasses.dataclass(frozen=True)
class _Staircase(Effect):
    """Friction that rises with the square of speed, up to a speed, and no further."""

    joint: int
    speed: float
    name = "capped_drag"

    @property
    def parameters(self):
        return (Parameter(f"Fk_{self.joint + 1}", "N m", self.joint),)

    @property
    def depends_on(self):
        return (f"dq_{self.joint + 1}",)

    def entries(self, state):
        share = np.minimum(np.abs(state.dq[self.joint]) / self.speed, 1.0)
        return [{self.joint: share**2 * np.sign(state.dq[self.joint])}]


def _capped_drag(_context, target, values):
    return _Staircase(target, values[0])


PAGE = EffectPage("F min(|dq|/v, 1)² s", "a user's own", "F in N m", "a step", (), "speeds")


@pytest.fixture
def own_catalogue():
    """What a test registers is gone after it: the catalogue is the process's."""
    before = dict(CATALOGUE)
    yield
    for name in set(CATALOGUE) - set(before):
        del _ENTRIES[name]


@pytest.mark.usefixtures("own_catalogue")
def test_an_effect_from_outside_is_fitted_and_named():
    entry = named_effect(
        "capped_drag", page=PAGE, shapes=(Shape("speed", "rad/s", 0.05, 2.0, "log", 8, 0.5),)
    )(_capped_drag)
    assert CATALOGUE["capped_drag"] is entry

    def drag(q, dq, ddq):
        result = np.zeros_like(q)
        result[:, 1] = 0.8 * np.minimum(np.abs(dq[:, 1]) / 0.6, 1) ** 2 * np.sign(dq[:, 1])
        return result

    dataset = data_set(34, extra=drag, repetitions=2)
    model = TorqueModel.standard(dataset.robot)
    found = diagnose(dataset, model, names=("capped_drag", "stribeck"))
    (effect,) = found.effects
    assert (effect.name, effect.joint) == ("capped_drag", 1)
    assert {p.name: p.value for p in effect.parameters}["speed"] == pytest.approx(0.6, rel=0.2)


def test_a_name_that_is_taken_is_refused():
    with pytest.raises(ValueError, match="'stribeck' already"):
        named_effect("stribeck", page=PAGE)(lambda *_: _Staircase(0, 1.0))
    assert register(CATALOGUE["stribeck"]) is CATALOGUE["stribeck"]
