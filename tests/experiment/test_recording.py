"""A recording or data set that contradicts itself cannot be made."""

import dataclasses

import numpy as np
import pytest

from oed.experiment.dataset import DataSet
from oed.experiment.drive import Drive
from oed.experiment.recording import Recording
from oed.robot import imi_scara


def recording(**changed) -> Recording:
    fields = {
        "name": "a",
        "role": "estimation",
        "t": np.arange(5.0),
        "q": np.zeros((5, 2)),
        "tau": np.ones((5, 2)),
    }
    return Recording(**fields | changed)


def test_knows_its_size():
    made = recording(repetition=np.array([0, 0, 1, 1, 1]))
    assert (len(made), made.n, made.duration, made.repetitions) == (5, 2, 4.0, 2)
    assert recording().repetitions == 1


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"t": np.array([0.0, 1, 2, 2, 3])}, r"sample 3: 2 s is followed by 2 s"),
        ({"t": np.array([0.0, 1, 2, 1, 3])}, r"sample 3: 2 s is followed by 1 s"),
        ({"q": np.full((5, 2), np.nan)}, "q is not finite at sample 0"),
        ({"dq": np.full((5, 2), np.inf)}, "dq is not finite at sample 0"),
        ({"period": 0.0}, "not positive"),
    ],
)
def test_refuses_numbers_that_cannot_be(changed, message):
    with pytest.raises(ValueError, match=message):
        recording(**changed)


# The shape checks of the tests come first and say so in their own way; a user has only these.
@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"t": np.arange(4.0)}, "t has 4 samples, q has 5"),
        ({"tau": np.ones((5, 3))}, r"tau is \(5, 3\), q is \(5, 2\)"),
        ({"ddq": np.ones((4, 2))}, r"ddq is \(4, 2\), q is \(5, 2\)"),
        ({"repetition": np.zeros(3, dtype=int)}, "repetition has 3 samples, t has 5"),
        ({"role": "train"}, "role 'train' is none of"),
    ],
)
def test_says_both_numbers_that_disagree(changed, message):
    made = object.__new__(Recording)
    values = {f.name: f.default for f in dataclasses.fields(Recording)}
    values |= {name: getattr(recording(), name) for name in ("name", "role", "t", "q", "tau")}
    for name, value in (values | changed).items():
        object.__setattr__(made, name, value)
    with pytest.raises(ValueError, match=message):
        Recording.__post_init__(made)


def dataset(*recordings: Recording, **changed) -> DataSet:
    fields = {"name": "d", "source": "s", "licence": "l", "robot": imi_scara(), "torque": "current"}
    return DataSet(**fields | changed, recordings=recordings)


def test_roles_sort_the_recordings():
    made = dataset(recording(), recording(name="b", role="test"), recording(name="c"))
    assert [r.name for r in made.estimation] == ["a", "c"]
    assert [r.name for r in made.test] == ["b"]
    assert made.validation == ()


def test_refuses_recordings_that_do_not_fit():
    with pytest.raises(ValueError, match="named twice"):
        dataset(recording(), recording())
    with pytest.raises(ValueError, match=r"has 3 joints, robot 'imi_scara' has 2"):
        dataset(recording(q=np.zeros((5, 3)), tau=np.zeros((5, 3))))
    with pytest.raises(ValueError, match="gear_ratio of 1 joints, the robot has 2"):
        dataset(drive=Drive(gear_ratio=np.ones(1)))
