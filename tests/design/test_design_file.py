"""What a design file says of an earlier experiment is what that experiment told."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from oed.design.design import Design
from oed.design.design_file import design_record
from oed.design.optimisers.result import OptimiserResult
from oed.design.prior_experiments import prior_information
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass
from oed.design.trajectories.registry import restore_motion
from oed.report.json_file import write_json
from tests.design.problems import HORIZON, classes, paper_problem, scara

ROBOT, MODEL, BASE = scara()
CLASSES = classes(ROBOT.limits)


def design(problem: DesignProblem, seed: int) -> Design:
    z = problem.random_start(np.random.default_rng(seed))
    return Design.from_result(problem, OptimiserResult(z, 0.0, (), 0, 0.0, "random"))


def written(found: Design, path: Path) -> Path:
    write_json(path, design_record(found, versions={"oed": "0"}))
    return path


def earlier(folder: Path, seed: int = 0, *, at_rest: bool = False) -> tuple[Design, Path]:
    """An experiment unlike the one to come: its own horizon, harmonics and instants."""
    trajectory = FourierClass(7.0, ROBOT.limits, harmonics=3, at_rest=at_rest)
    problem = dataclasses.replace(paper_problem(trajectory), instants=trajectory.instants(33))
    found = design(problem, seed)
    return found, written(found, folder / f"design_{seed}.json")


def next_problem() -> DesignProblem:
    return paper_problem(FourierClass(HORIZON, ROBOT.limits))


@pytest.mark.parametrize("at_rest", [False, True])
def test_the_prior_is_the_information_of_the_earlier_experiment(
    at_rest: bool, tmp_path: Path
) -> None:
    found, file = earlier(tmp_path, at_rest=at_rest)
    prior = prior_information([file], next_problem())
    motion = found.motion(np.arange(33) * 7.0 / 33)
    H = BASE.reduce(MODEL.regressor(motion)).reshape(-1, len(BASE))
    np.testing.assert_allclose(prior, H.T @ H, rtol=1e-9, atol=1e-9 * prior.max())


def test_two_experiments_tell_the_sum_of_both(tmp_path: Path) -> None:
    (first, one), (second, two) = earlier(tmp_path, 0), earlier(tmp_path, 1)
    problem = next_problem()
    total = prior_information([one, two], problem)
    np.testing.assert_allclose(total, first.information + second.information, rtol=1e-9)
    completed = design(dataclasses.replace(problem, prior=total), 2)
    both = completed.problem.information(completed.z, scaled=False)
    np.testing.assert_allclose(both, total + completed.information, rtol=1e-9)
    record = design_record(completed, versions={})
    assert record["with_prior"] == {
        "J_k": pytest.approx(np.linalg.cond(both), rel=1e-6),
        "J_d_log10": pytest.approx(np.linalg.slogdet(both)[1] / np.log(10)),
    }
    assert record["J_d_log10"] == pytest.approx(
        np.linalg.slogdet(completed.information)[1] / np.log(10)
    )
    assert design_record(first, versions={})["with_prior"] is None


def test_coefficients_in_the_file_are_the_motion(tmp_path: Path) -> None:
    found, file = earlier(tmp_path, at_rest=True)
    record = json.loads(file.read_text())
    series, t = record["coefficients"], np.linspace(0.0, 7.0, 50)
    q = np.array(series["offset"]) + sum(
        np.outer(np.sin(k * series["fundamental"] * t), np.array(series["sine"])[:, k - 1])
        + np.outer(np.cos(k * series["fundamental"] * t), np.array(series["cosine"])[:, k - 1])
        for k in (1, 2, 3)
    )
    np.testing.assert_allclose(found.motion(t).q, q, atol=1e-12)
    assert record["joints"] == list(ROBOT.joint_names)
    assert record["horizon"] == 7.0
    assert record["rows"] == 33 * 2


def refused(content: str, folder: Path) -> str:
    """The one line in which a file is refused; it names the file."""
    (folder / "bad.json").write_text(content, encoding="utf-8")
    with pytest.raises(ValueError, match=r"bad\.json") as caught:
        prior_information([folder / "bad.json"], next_problem())
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"absent\.json: no such file"):
        prior_information([tmp_path / "absent.json"], next_problem())


@pytest.mark.parametrize(
    "content",
    ["", "{", "no design", '{"joints": [1,}', "[" * 200_000, '{"horizon": Infinity}', "1e999"],
)
def test_a_file_that_is_not_json_is_refused(content: str, tmp_path: Path) -> None:
    assert "not JSON" in refused(content, tmp_path)


@pytest.mark.parametrize("content", ["[]", "3", '"text"', "null", "{}", '{"joints": ["a"]}'])
def test_json_that_is_no_design_is_refused(content: str, tmp_path: Path) -> None:
    assert "not a design file" in refused(content, tmp_path)


@pytest.mark.parametrize(
    ("key", "value", "why"),
    [
        ("instants", 10**9, "instants at most"),
        ("instants", -1, "must be positive"),
        ("joints", ["joint"] * 1_000_000, "letters left out"),
        ("class", "x" * 1_000_000, "letters left out"),
        (
            "coefficients",
            {"offset": [0, 0], "sine": [[0] * 999] * 2, "cosine": []},
            "999 harmonics",
        ),
    ],
)
def test_a_design_beyond_all_bounds_is_refused(
    key: str, value: object, why: str, tmp_path: Path
) -> None:
    _, file = earlier(tmp_path)
    message = refused(json.dumps(json.loads(file.read_text()) | {key: value}), tmp_path)
    assert why in message
    assert len(message) < 4000


def test_another_robots_motion_is_refused(tmp_path: Path) -> None:
    _, file = earlier(tmp_path)
    record = json.loads(file.read_text()) | {"joints": ["shoulder", "elbow"]}
    message = refused(json.dumps(record), tmp_path)
    assert "shoulder" in message
    assert ROBOT.joint_names[0] in message


@pytest.mark.parametrize("name", CLASSES)
def test_a_motion_of_any_class_is_read_back(name: str, tmp_path: Path) -> None:
    trajectory = CLASSES[name]
    found = design(paper_problem(trajectory), 0)
    record = json.loads(written(found, tmp_path / "design.json").read_text())
    given = {key: np.array(x) for key, x in record["coefficients"].items()}
    restored, z = restore_motion(record["class"], record["horizon"], ROBOT.limits, given)
    t = np.linspace(0.0, HORIZON, 77)
    for order in range(4):
        before = trajectory.derivative(found.z, t, order)
        after = restored.derivative(z, t, order)
        np.testing.assert_allclose(after, before, atol=1e-10 * max(1.0, np.abs(before).max()))
    prior = prior_information([tmp_path / "design.json"], next_problem())
    np.testing.assert_allclose(prior, found.information, rtol=1e-8, atol=1e-8 * prior.max())


def test_a_class_that_nobody_registered_is_refused(tmp_path: Path) -> None:
    _, file = earlier(tmp_path)
    record = json.loads(file.read_text()) | {"class": "zigzag"}
    assert "a motion of class 'zigzag'; known are fourier" in refused(json.dumps(record), tmp_path)


@pytest.mark.parametrize(
    "coefficients",
    [
        {},
        {"control_points": [[0.0] * 20] * 3, "degree": 3},
        {"control_points": [[0.0] * 20] * 2, "degree": 99},
        {"control_points": [[0.0] * 5] * 2, "degree": 3},
        {"control_points": [[0.0] * 20] * 2, "degree": [3, 3]},
    ],
)
def test_misshapen_splines_are_refused(coefficients: dict, tmp_path: Path) -> None:
    _, file = earlier(tmp_path)
    record = json.loads(file.read_text()) | {"class": "spline", "coefficients": coefficients}
    refused(json.dumps(record), tmp_path)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("offset", None),
        ("sine", [[1.0, 2.0]]),
        ("cosine", [0.1, 0.2]),
        ("offset", [0.0, 0.0, 0.0]),
        ("sine", [[], []]),
        ("sine", [[0.1, 0.1, float("nan")]] * 2),
        ("offset", ["a", "b"]),
        ("sine", [[0.1], [0.1, 0.2]]),
    ],
)
def test_misshapen_coefficients_are_refused(key: str, value: object, tmp_path: Path) -> None:
    _, file = earlier(tmp_path)
    record = json.loads(file.read_text())
    record["coefficients"][key] = value
    refused(json.dumps(record), tmp_path)
    del record["coefficients"][key]
    refused(json.dumps(record), tmp_path)


@pytest.mark.parametrize(
    ("key", "value"), [("horizon", 0.0), ("horizon", -3.0), ("instants", 0), ("horizon", "long")]
)
def test_an_impossible_experiment_is_refused(key: str, value: object, tmp_path: Path) -> None:
    _, file = earlier(tmp_path)
    refused(json.dumps(json.loads(file.read_text()) | {key: value}), tmp_path)
