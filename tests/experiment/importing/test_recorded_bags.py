"""Two bags recorded on real arms, from file to estimate without a word from the user."""

import pytest

from oed.dynamics.models import build_model
from oed.estimation.calibration import calibrate
from oed.estimation.velocity_choice import choose_velocity
from oed.experiment.importing.import_log import ImportChoices, propose_import
from oed.experiment.preparation.settings import choose_settings
from tests.paths import SHARED_LOGS, example_robot, needs_shared_logs

BANDS = {"ur10": 25.0, "panda": 3.4}  # [Hz] in which the errors were found


@needs_shared_logs
@pytest.mark.parametrize(
    ("name", "urdf", "rows", "error"),
    [
        ("ur10", "ur_description/urdf/ur10_robot.urdf", 3441, {"test": 0.065}),
        (
            "panda",
            "panda_description/urdf/panda.urdf",
            727,
            {"estimation": 0.0173, "validation": 0.0206, "test": 0.0167},
        ),
    ],
)
def test_a_recorded_bag_gives_the_errors_that_are_known(name, urdf, rows, error, tmp_path):
    """Figures: an earlier fit of the same model to a split by time, by other code."""
    bag = SHARED_LOGS / f"{name}_exciting_trajectory.db3"
    choices = ImportChoices(robot=str(example_robot(urdf)))
    found = propose_import([bag], choices, tmp_path / name)
    dataset = found.dataset
    assert sum(len(r) for r in dataset.recordings) == rows
    assert any("a clock that starts at zero" in note for note in found.notes)
    model = build_model("rotor", dataset.robot, sign_width=0.02)
    settings = choose_velocity(
        dataset, model, choose_settings(dataset.recordings, cutoff=BANDS[name])
    )
    validation = calibrate(dataset, model, settings).validation
    for role, expected in error.items():
        assert 0.8 * expected < validation[role].overall_relative_rms < 1.05 * expected
