"""What is asked of a long log is asked a piece at a time: the same answers, never all rows at once."""

import dataclasses
import tracemalloc

import numpy as np
import pytest

from oed.checkup.delay import find_delay
from oed.checkup.projection import project
from oed.checkup.trial import Trials
from oed.dynamics.effects import rigid_body
from oed.estimation.feasible.calibration import validate_parameters
from oed.estimation.feasible.data_factor import block_factors
from oed.experiment.preparation import processed
from tests.checkup.simulated_arm import dataset, model_of, recorded
from tests.checkup.simulated_arm import processed as by_role

PIECE = 300


def numbers(found):
    """All numbers of a result, one after another."""
    return np.concatenate([np.ravel(x) for x in dataclasses.astuple(found)])


def tried(model, recordings):
    trials = Trials(model, tuple(r for group in recordings.values() for r in group))
    outcome = trials.as_logged
    return np.concatenate([outcome.relative, outcome.residual, trials.independent(outcome)])


def in_blocks(model, recordings):
    factors = block_factors(model, recordings["estimation"], blocks=3)
    assert len(factors) == 3
    # A triangle without full rank is one of many of the same rows; their products are one.
    triangles = [joint.triangle for block in factors for joint in block.joints]
    return np.concatenate([np.ravel(triangle.T @ triangle) for triangle in triangles])


def validated(model, recordings):
    parameters = np.linspace(0.1, 1.0, len(model.parameters))
    return numbers(validate_parameters(model, parameters, recordings["estimation"]))


ASKED = {
    "trial": tried,
    "blocks": in_blocks,
    "validation": validated,
    "projection": lambda model, recordings: numbers(project(model, recordings)),
    "delay": lambda model, recordings: numbers(find_delay(model, recordings["estimation"])),
}


@pytest.fixture(scope="module")
def log():
    lengths = (1, "estimation", "fit", 60.0), (2, "validation", "held", 12.0)
    data = dataset(recordings=tuple(recorded(*given) for given in lengths))
    rng = np.random.default_rng(1)
    recordings = {
        role: tuple(
            dataclasses.replace(r, certainty=rng.uniform(0.2, 1.0, r.tau.shape)) for r in group
        )
        for role, group in by_role(data).items()
    }
    return model_of(data.robot), recordings


@pytest.mark.parametrize("ask", ASKED.values(), ids=ASKED)
def test_pieces_say_what_the_whole_says(ask, log, monkeypatch):
    whole = ask(*log)
    monkeypatch.setattr(processed, "PIECE", PIECE)
    np.testing.assert_allclose(ask(*log), whole, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("ask", ASKED.values(), ids=ASKED)
def test_the_rows_of_a_whole_recording_are_never_held(ask, log, monkeypatch):
    model, recordings = log
    monkeypatch.setattr(processed, "PIECE", PIECE)
    monkeypatch.setattr(rigid_body, "KEPT_BYTES", 0)  # bounded by itself
    ask(model, recordings)  # what is compiled or loaded once
    rows = max(len(r) for group in recordings.values() for r in group)
    whole = rows * model.robot.n * len(model.parameters) * np.dtype(float).itemsize
    tracemalloc.start()
    ask(model, recordings)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < whole
