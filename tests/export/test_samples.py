"""Samples are the estimate's normal distribution, cut off where no body can be."""

import dataclasses
import json

import numpy as np
import pytest
from scipy.stats import truncnorm

from oed.commands.main import run
from oed.dynamics.motion import random_motion
from oed.errors import NoUsableResult
from oed.export.bodies import calibrated_robot
from oed.export.model_file import write_model
from oed.export.samples import FeasibleRegion, draw_models, kept_spread
from tests.export.every_effect import model_with

COUNT = 200


def known(relative, names=()):
    """A model whose parameters are known to some share of themselves."""
    model, _ = model_with(*names, duration=0.2)
    std = relative * np.abs(model.parameters)
    return dataclasses.replace(model, covariance=np.diag(std**2), estimated=std > 0), std


@pytest.fixture(scope="module")
def narrow():
    """Far from every edge."""
    model, std = known(1e-4, ("stribeck",))
    return model, std, draw_models(model, COUNT, np.random.default_rng(3))


def test_far_from_edges_they_have_mean_and_spread_of_the_estimate(narrow):
    model, std, drawn = narrow
    used = std > 0
    off = (drawn.mean(axis=0) - model.parameters)[used] / std[used]
    assert np.abs(off).max() < 4 / np.sqrt(COUNT)
    assert drawn.std(axis=0)[used] == pytest.approx(std[used], rel=0.2)


def test_draws_forget_one_another(narrow):
    model, std, drawn = narrow
    z = ((drawn - model.parameters) / np.where(std > 0, std, 1))[:, std > 0]
    following = np.mean(z[1:] * z[:-1], axis=0)
    assert np.abs(following).max() < 4 / np.sqrt(COUNT)


def test_their_torque_spreads_as_the_covariance_says(narrow):
    model, _, drawn = narrow
    motion = random_motion(model.robot, 30, np.random.default_rng(0))
    columns = model.torque_model.columns(motion)
    spread = np.std(columns @ drawn.T, axis=2)
    expected = np.sqrt(np.einsum("kjp,p->kj", columns**2, np.diag(model.covariance)))
    assert spread == pytest.approx(expected, rel=0.2)


def test_at_an_edge_they_are_the_truncated_normal():
    model, std = known(0.0, ("stribeck",))
    name = [p.name for p in model.torque_model.parameters].index("Fs_2")
    std[name] = 1.0  # beside a value of 0.5, of which no less than 0 is possible
    wide = dataclasses.replace(model, covariance=np.diag(std**2))
    drawn = draw_models(wide, COUNT, np.random.default_rng(4))[:, name]
    size = model.parameters[name]
    expected = truncnorm(-size, np.inf, loc=size)
    assert drawn.min() >= 0
    assert drawn.mean() == pytest.approx(expected.mean(), abs=4 * expected.std() / np.sqrt(COUNT))
    assert np.median(drawn) == pytest.approx(expected.median(), abs=0.15)


def test_every_sample_is_possible_where_half_of_a_normals_are_not():
    model, _ = known(0.4, ("stribeck", "load_dependent_friction"))
    drawn = draw_models(model, 30, np.random.default_rng(5))
    region = FeasibleRegion.of(model)
    for parameters in drawn:
        calibrated_robot(dataclasses.replace(model, parameters=parameters))
        assert (region.weights @ parameters >= region.bounds - 1e-12).all()
    assert drawn.std(axis=0)[0] > 0


@pytest.mark.parametrize(("relative", "is_cut"), [(1e-4, False), (0.4, True)])
def test_what_the_cut_takes_of_the_spread_of_torque_is_told(relative, is_cut):
    model, std = known(relative, ("stribeck",))
    rng = np.random.default_rng(6)
    cut, free = (
        draw_models(model, 200, rng),
        model.parameters + std * rng.normal(size=(200, len(std))),
    )
    rows = model.torque_model.regressor(random_motion(model.robot, 300, rng))
    spreads = [np.std(rows @ each.T, axis=1) for each in (cut, free)]
    truth = np.median(spreads[0] / spreads[1])
    assert kept_spread(model, cut, rng) == pytest.approx(truth, abs=0.08)
    assert (kept_spread(model, cut, rng) < 0.9) == is_cut


@pytest.mark.parametrize(("relative", "is_told"), [(0.01, False), (0.4, True)])
def test_the_command_says_where_samples_spread_less_than_the_estimate(
    relative, is_told, tmp_path, capsys
):
    model, _ = known(relative, ("stribeck",))
    path = write_model(model, tmp_path / "model.json")
    given = ["export", str(path), "--samples", "5", "--out", str(tmp_path / "out")]
    assert run(given) == 0
    assert ("of what the covariance says" in capsys.readouterr().out) == is_told
    told = json.loads((tmp_path / "out" / "samples.json").read_text(encoding="utf-8"))
    assert len(told["samples"]) == 5


def test_the_command_writes_samples_and_ranges(tmp_path):
    model, _ = known(0.05, ("stribeck",))
    path = write_model(model, tmp_path / "model.json")
    out = tmp_path / "out"
    assert run(["export", str(path), "--samples", "20", "--out", str(out)]) == 0
    told = json.loads((out / "samples.json").read_text(encoding="utf-8"))
    assert np.array(told["samples"]).shape == (20, len(model.parameters))
    ranges = json.loads((out / "randomisation.json").read_text(encoding="utf-8"))
    link = model.robot.joints[1].link
    low, high = ranges["body"][link]["mass"]
    assert low < model.parameters[10] < high
    low, high = ranges["joint"][model.robot.joint_names[0]]["damping"]
    assert low < 1.0 < high
    assert set(ranges["effect"]) == {"Fs_2"}


def test_without_covariance_nothing_is_drawn():
    model, _ = known(0.1)
    with pytest.raises(NoUsableResult, match="no covariance"):
        draw_models(dataclasses.replace(model, covariance=None), 1, np.random.default_rng(0))
