"""What each addition gives over a coordinate, against the function that was put in."""

import numpy as np
import pytest

from oed.diagnosis.inference.curves import curve
from oed.diagnosis.inference.errors import Predictor
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepare import prepare
from tests.diagnosis.arm import data_set


class _Known(Predictor):
    """Predicts friction that varies with position, of a size."""

    def torque(self, prepared):
        instants, motion = prepared.band.instants, prepared.motion
        q, dq = (np.stack([*map(instants, x.T)], axis=1) for x in (motion.q, motion.dq))
        return self.parameters[0] * np.sin(q) * np.sign(dq)


@pytest.mark.parametrize(
    ("coordinates", "name", "is_along"),
    [(("q_1", "dq_1"), "q_1", True), (("q_1",), "q_1", False), (("dq_1",), "dq_1", False)],
)
def test_friction_over_position_is_shown_along_the_motion(coordinates, name, is_along):
    dataset = data_set(3, repetitions=1)
    rows, model = prepare(dataset.estimation), TorqueModel.standard(dataset.robot)
    after, rest = (_Known(model, np.array([size])) for size in (2.0, 0.0))
    floor = np.array([0.01, np.inf])
    found = curve("f", rows, after=after, rest=rest, coordinates=coordinates, floor=floor)
    assert found is not None
    assert (found.joint, found.coordinate, found.is_along) == (0, name, is_along)
    if is_along:
        assert found.given == pytest.approx(2 * np.sin(found.centre), abs=0.05)


class _Stop(Predictor):
    """Predicts what pushes back near the end of the range, and a weak torque of one way of motion."""

    def torque(self, prepared):
        instants, motion = prepared.band.instants, prepared.motion
        q, dq = (instants(x[:, 0]) for x in (motion.q, motion.dq))
        given = np.where(q > np.quantile(q, 0.95), 100.0, np.where(dq < 0, 0.2, 1.0))
        return self.parameters[0] * np.stack([given, 0 * given], axis=1)


def test_an_addition_is_shown_over_what_most_of_its_torque_depends_on():
    """The stop is rare; of the squares of what is given all but a thousandth are its own."""
    dataset = data_set(3, repetitions=1, roles=("estimation",))
    rows, model = prepare(dataset.estimation), TorqueModel.standard(dataset.robot)
    after, rest = (_Stop(model, np.array([size])) for size in (1.0, 0.0))
    how = {"after": after, "rest": rest, "floor": np.ones(2)}
    found = curve("f", rows, coordinates=("q_1", "dq_1"), **how)
    assert found is not None
    assert (found.coordinate, found.is_along) == ("q_1", False)
    assert found.given[-1] == pytest.approx(100.0)
