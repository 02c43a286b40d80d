"""The Python that the documentation shows runs, and does what the page says."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from oed.design.optimisers import registry as optimisers
from oed.design.trajectories import registry as trajectories
from oed.dynamics.compiled import compile_regressor
from oed.dynamics.effects import catalogue
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.logs import registry
from oed.experiment.read_dataset import read_dataset
from tests.docs.code_blocks import blocks
from tests.experiment.tiny_dataset import tiny_files, write_files
from tests.paths import REPO
from tests.running import oed

HOW_TO = REPO / "docs/how-to"


def test_the_readme_s_example(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (example,) = blocks(REPO / "README.md", "python")
    _write_arm(tmp_path / "mydata")
    monkeypatch.chdir(tmp_path)
    exec(compile(example, "README.md", "exec"), {})  # noqa: S102  # our own page
    told = capsys.readouterr().out
    assert "Fv_1" in told
    assert "held-out error" in told


@pytest.fixture
def own_readers() -> Iterator[None]:
    """What a page registers is forgotten."""
    before = dict(registry._readers)
    yield
    registry._readers.clear()
    registry._readers.update(before)


@pytest.mark.usefixtures("own_readers")
def test_a_log_reader_from_outside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    t = np.arange(0.0, 20.0, 0.02)
    q = np.stack([0.5 * np.sin(1.3 * t) + 0.2 * np.sin(3 * t), 0.6 * np.sin(1.7 * t)], axis=1)
    rows = np.column_stack([t, q, q * 3.0 + np.sin(5 * t)[:, None]])
    rows.astype("<f8").tofile(tmp_path / "log.arm")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks(HOW_TO / "log-reader.md", "python"):
        exec(compile(block, "log-reader.md", "exec"), names)  # noqa: S102  # our own page
    assert names["status"] == 0
    dataset = read_dataset("mydata")
    np.testing.assert_allclose(dataset.recordings[0].q[:50], q[:50])


def _write_arm(folder: Path) -> None:
    """A data set with a validation recording whose numbers an estimate can be made of."""
    files = tiny_files()
    files["dataset.toml"] = files["dataset.toml"].replace(b'"test"', b'"validation"')
    write_files(folder, files)
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 12.0, 0.01)
    rates = rng.uniform(1.0, 4.0, (3, 2))
    for name in ("estimation.csv", "test.csv"):
        phases = t[:, None, None] * rates + rng.uniform(0, 6, (3, 2))
        q, dq = 0.5 * np.sin(phases).sum(axis=1), 0.5 * (rates * np.cos(phases)).sum(axis=1)
        ddq = -0.5 * (rates**2 * np.sin(phases)).sum(axis=1)
        tau = 2.0 * ddq + 3.0 * dq + rng.normal(0, 0.05, q.shape)
        table = np.column_stack([t, q, tau])
        header = "t,q_1,q_2,tau_1,tau_2"
        np.savetxt(folder / name, table, delimiter=",", header=header, comments="")
    manifest = (folder / "dataset.toml").read_text()
    (folder / "dataset.toml").write_text(manifest.replace("repetitions = 3\nperiod = 1.0\n", ""))


@pytest.fixture
def own_optimisers() -> Iterator[None]:
    before = dict(optimisers.OPTIMISERS.added)
    yield
    optimisers.OPTIMISERS.added.clear()
    optimisers.OPTIMISERS.added.update(before)


@pytest.mark.usefixtures("own_optimisers")
def test_an_optimiser_from_outside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks(HOW_TO / "optimiser.md", "python"):
        exec(compile(block, "optimiser.md", "exec"), names)  # noqa: S102  # our own page
    assert names["status"] == 0
    record = json.loads(Path("design/design.json").read_text())
    assert record["optimiser"] == "local_steps"
    assert record["usable"]


def test_an_unknown_optimiser_is_refused_with_those_there_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--robot", "builtin:imi_scara", "--out", tmp_path / "d", "--optimiser", "simplex"]
    assert oed("design", *arguments) == 2
    assert "slsqp" in capsys.readouterr().err
    assert not (tmp_path / "d").exists()


@pytest.fixture
def own_trajectories() -> Iterator[None]:
    before = dict(trajectories.CLASSES.added)
    yield
    trajectories.CLASSES.added.clear()
    trajectories.CLASSES.added.update(before)


@pytest.mark.usefixtures("own_trajectories")
def test_a_class_of_trajectories_from_outside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks(HOW_TO / "trajectory.md", "python"):
        exec(compile(block, "trajectory.md", "exec"), names)  # noqa: S102  # our own page
    assert names["status"] == 0
    record = json.loads(Path("design/design.json").read_text())
    assert record["usable"]
    # Two sines a joint that are no faster than the page's bound.
    frequency = np.array(record["coefficients"]["frequency"])
    assert frequency.shape == (2, 2)
    assert (frequency <= 3.0).all()


def test_what_a_class_cannot_do_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--robot", "builtin:imi_scara", "--out", tmp_path / "d", "--smoke"]
    assert oed("design", *arguments, "--trajectory", "harmonic", "--scale", 0.5) == 2
    assert "cannot be slowed down" in capsys.readouterr().err
    assert oed("design", *arguments, "--trajectory", "zigzag") == 2
    assert "known are fourier, harmonic" in capsys.readouterr().err


@pytest.fixture
def own_effects() -> Iterator[None]:
    before = dict(catalogue._ENTRIES)
    yield
    catalogue._ENTRIES.clear()
    catalogue._ENTRIES.update(before)


@pytest.mark.usefixtures("own_effects")
def test_an_effect_from_outside() -> None:
    names: dict[str, object] = {}
    for block in blocks(HOW_TO / "effect.md", "python"):
        exec(compile(block, "effect.md", "exec"), names)  # noqa: S102  # our own page
    model = names["model"]
    assert isinstance(model, TorqueModel)
    t = np.linspace(0.0, 6.0, 40)
    q = np.stack([np.sin(t), 0.5 * np.sin(2 * t)], axis=1)
    dq = np.stack([np.cos(t), np.cos(2 * t)], axis=1)
    motion = Motion(t, q, dq, -q * (1.0, 4.0))
    column = model.regressor(motion).reshape(len(t), 2, -1)[:, :, -1]
    x = dq[:, 1] / 0.5
    np.testing.assert_allclose(column[:, 1], np.sign(x) * x**2 / (1 + x**2), atol=1e-12)
    np.testing.assert_array_equal(column[:, 0], 0.0)
    # The same lines in CasADi: the compiled regressor predicts the same torque.
    parameters = np.random.default_rng(0).normal(size=len(model.parameters))
    base = base_parameters(model)
    compiled = compile_regressor(model, base, native=False)
    reduced = compiled.dense(compiled.entries(motion))
    told = reduced.reshape(len(t) * 2, -1) @ base.from_standard(parameters)
    np.testing.assert_allclose(told, model.torque(parameters, motion).reshape(-1), atol=1e-9)
    entry = catalogue.CATALOGUE["fan_drag"]
    assert (entry.scope, entry.page.exposed_by) == ("joint", names["fan_drag"].page.exposed_by)
