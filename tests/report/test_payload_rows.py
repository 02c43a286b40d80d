"""What is said of a load's interval, and that there is none where the data do not bound it."""

import dataclasses

import numpy as np
import pytest

from oed.estimation.load.known_arm import KnownArm
from oed.estimation.load.loaded_model import LoadedModel
from oed.estimation.load.payload import estimate_payload, with_friction
from oed.estimation.load.undetermined import OpenQuantity
from oed.report.payload_rows import friction_lines, interval_words, untold_lines
from tests.estimation.load.carrying_arm import FRAME, MODEL, ROBOT, recording


@pytest.mark.parametrize(
    ("interval", "words"),
    [((0.95, 1.25), "0.95 to 1.25 kg"), (None, "the data do not bound it")],
)
def test_an_interval_is_said_with_its_unit_or_that_there_is_none(interval, words):
    assert interval_words(interval, "kg") == words


def test_a_mass_without_a_bound_is_said_to_have_none():
    rng = np.random.default_rng(3)
    bare, loaded = (recording(rng, 10.0, is_loaded=x) for x in (False, True))
    found, without = (
        estimate_payload(KnownArm.from_recordings(model, [bare]), [loaded])
        for model in (
            LoadedModel.bare(MODEL, FRAME),
            LoadedModel.bare(MODEL, FRAME, has_load_friction=False),
        )
    )
    mass, *rest = without.quantities
    unbounded = dataclasses.replace(mass, interval=None)
    open_ended = dataclasses.replace(without, quantities=(unbounded, *rest))
    (line,) = friction_lines(with_friction(found, open_ended), ROBOT.joint_names)
    assert f"would be {without.mass:.4g} kg (the data do not bound it)" in line
    (line,) = friction_lines(with_friction(found, without), ROBOT.joint_names)
    assert mass.interval is not None
    low, high = mass.interval
    assert f"would be {without.mass:.4g} kg ({low:.4g} to {high:.4g} kg)" in line


def test_quantities_that_the_same_would_tell_share_a_line() -> None:
    heavier, wrist = "a heavier load", "turn the wrist"
    open_ones = [
        OpenQuantity("mass", "the mass", heavier),
        OpenQuantity("x", "the centre of mass along x", wrist),
        OpenQuantity("y", "the centre of mass along y", heavier),
    ]
    assert untold_lines(open_ones) == (
        "not told: the mass, the centre of mass along y; a heavier load",
        "not told: the centre of mass along x; turn the wrist",
    )
