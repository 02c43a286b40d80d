"""A torque that is logged late is found with its time, and a log in time is left alone."""

import pytest

from oed.checkup.delay import delay_finding, find_delay
from tests.checkup.simulated_arm import dataset, later, model_of, processed


def found_in(data):
    model = model_of(data.robot)
    whole = processed(data)
    return find_delay(model, whole["estimation"]), delay_finding(data, model, whole)


def test_a_log_in_time_is_left_alone():
    delay, finding = found_in(dataset())
    assert abs(delay.seconds) < 1e-3
    assert finding.level == "green"


@pytest.mark.parametrize("seconds", [0.03, -0.02])
def test_a_shift_is_found_with_its_size_and_side(seconds):
    delay, finding = found_in(dataset(lambda recording: later(recording, seconds)))
    assert delay.seconds == pytest.approx(seconds, abs=1.5e-3)
    assert finding.level == "amber"
    assert ("after" if seconds > 0 else "before") in finding.text
    assert delay.gain > 0.3
    # The best shift leaves what noise leaves: the band's share of it.
    assert (delay.after < 0.05).all()


def test_a_shift_that_only_the_fitted_recordings_have_is_not_told():
    def only_fitted(recording):
        return later(recording, 0.03) if recording.role == "estimation" else recording

    delay, finding = found_in(dataset(only_fitted))
    assert delay.seconds == pytest.approx(0.03, abs=1.5e-3)
    assert finding.level == "green"
