"""What the page of a diagnosis draws is what its table counts."""

import numpy as np
import pytest

from oed.commands.diagnosed_torques import diagnosed_torques
from oed.diagnosis.diagnose import Diagnosis, diagnose
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.settings import ProcessingSettings, choose_settings
from oed.report.torque_charts import Rows
from tests.diagnosis.arm import data_set, stribeck


@pytest.fixture(scope="module")
def diagnosed() -> tuple[Diagnosis, DataSet, ProcessingSettings]:
    data = data_set(31, extra=stribeck(1.5, 0.15), repetitions=2)
    settings = choose_settings(data.recordings)
    model = TorqueModel.standard(data.robot)
    return diagnose(data, model, settings=settings, names=("stribeck",), most=1), data, settings


def test_residuals_have_the_errors_of_the_table(
    diagnosed: tuple[Diagnosis, DataSet, ProcessingSettings],
) -> None:
    found, *_ = diagnosed
    assert found.effects
    told = diagnosed_torques(*diagnosed)
    assert [t.role for t in told] == [e.role for e in found.errors]
    for torques, errors in zip(told, found.errors, strict=True):
        for name, rms in (("before", errors.before), ("after", errors.after)):
            left = torques.rows.measured - torques.rows.predicted[name]
            # The table counts rows less whose direction of motion is uncertain.
            np.testing.assert_allclose(np.sqrt(np.nanmean(left**2, axis=0)), rms, rtol=0.15)
        assert errors.before[0] > 1.5 * errors.after[0]
        np.testing.assert_array_equal(torques.band, found.noise_floor)


def test_recordings_stand_end_to_end_with_a_gap_between() -> None:
    one = Rows(np.array([5.0, 5.5, 6.0]), np.ones((3, 1)), {"m": np.zeros((3, 1))})
    both = Rows.end_to_end([one, one])
    times = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]
    np.testing.assert_array_equal(both.t[np.isfinite(both.t)], times)
    assert np.isnan(both.measured[3]).all()
    assert np.isnan(both.predicted["m"][3]).all()
    assert len(both.t) == 7
