"""Whatever is wrong with a log, there is one clear line, and nothing is written."""

import pytest

from oed.robot import load_robot
from tests.experiment.importing.laboratory_logs import LOGS, Truth, simulate
from tests.experiment.importing.log_fuzz import REFUSED, ROWS, Config, fuzz

ROUNDS = 77  # spoiled files of each kind, so that they are a thousand


@pytest.fixture(scope="module")
def truth(arm) -> Truth:
    return simulate(load_robot(arm), rows=ROWS)


@pytest.mark.parametrize("kind", LOGS)
def test_a_spoiled_log_is_imported_or_refused_in_one_line(kind, arm, truth, tmp_path):
    outcomes = fuzz(kind, truth, arm, tmp_path, Config(rounds=ROUNDS))
    assert [outcome.fault for outcome in outcomes if outcome.fault] == []
    assert sum(outcome.status == REFUSED for outcome in outcomes) > ROUNDS / 4
