"""Public recordings: made-up clones of the same layout, sealed rows that stay sealed, published models."""

import csv
import shutil
from types import SimpleNamespace
from typing import cast

import numpy as np
import pandas as pd
import pytest
import yaml

from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import rigid_body_torque
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.prepared import Prepared
from oed.report.table import read_csv
from oed.robot.builtin import imi_scara
from studies.public_arms import judge, panda_rome, pendulum_dfki, psm_worcester, study, tx40_nantes
from studies.public_arms.base_table import read_table, torque_of_table
from studies.public_arms.catalogue import ARMS
from studies.public_arms.clones import clone_of
from studies.public_arms.compiled import NoCompiler, compiled, equation_of_motion
from studies.public_arms.sealed import compare
from studies.public_arms.visited import beyond
from tests.diagnosis.arm import data_set

NUMBERS = {
    "I1": 0.05, "I2": 0.02, "Ir": 0.0, "b1": 0.0, "b2": 0.0, "cf1": 0.0, "cf2": 0.0, "g": 9.81, "gr": 6.0,
    "l1": 0.3, "l2": 0.2, "m1": 0.6, "m2": 0.5, "r1": 0.2, "r2": 0.15,
}  # fmt: skip


def motion(t, joints, seed=0):
    """Smooth and random."""
    rng = np.random.default_rng(seed)
    a, w, phase = (
        rng.uniform(0.2, 0.6, joints),
        rng.uniform(2, 5, joints),
        rng.uniform(0, 6, joints),
    )
    s = w * t[:, None] + phase
    return Motion(t, a * np.sin(s), a * w * np.cos(s), -a * w**2 * np.sin(s))


def written(path, columns):
    path.parent.mkdir(parents=True, exist_ok=True)
    pd.DataFrame(columns).to_csv(path, index=False)


def pendulum(clone):
    """A clone with five runs of other phases, its torques worked out from the robot's own parameters."""
    for seed, run in enumerate(pendulum_dfki.ROLES):
        x = motion(np.arange(0, 4, 0.005), 2, seed)
        columns = {"time": x.t} | {
            f"{name}{j + 1}": values[:, j]
            for name, values in (("pos", x.q), ("vel", x.dq), ("tau", np.sin(x.q) + x.dq))
            for j in range(2)
        }
        written(clone / pendulum_dfki.RUNS / f"20220812-{run}-PM_measured.csv", columns)
    file = clone / pendulum_dfki.MODEL
    file.parent.mkdir(parents=True)
    file.write_text(yaml.safe_dump(NUMBERS))


def test_the_pendulum_s_runs_have_their_roles_and_its_published_equations_are_newton_s(tmp_path):
    pendulum(tmp_path / "clone")
    dataset = pendulum_dfki.ARM.imported(tmp_path / "clone", tmp_path / "out")
    assert [r.role for r in dataset.recordings] == ["estimation"] * 3 + ["validation", "test"]
    x = motion(np.arange(0, 2, 0.01), 2, 9)
    m2, r2 = NUMBERS["m2"], NUMBERS["r2"]
    first = [NUMBERS["m1"], NUMBERS["m1"] * NUMBERS["r1"], *[0.0] * 7, NUMBERS["I1"]]
    second = [m2, m2 * r2, *[0.0] * 7, NUMBERS["I2"]]
    expected = rigid_body_torque(dataset.robot.with_parameters(np.array(first + second)), x)
    found = pendulum_dfki.published(tmp_path / "clone", tmp_path)(x)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_the_wrist_s_power_is_that_of_its_motors(tmp_path):
    t = np.arange(0, 7.5, 1 / tx40_nantes.RATE)
    x = motion(t, 6)
    turns = np.array(tx40_nantes.RATIO)[:, None] * np.eye(6)
    turns[5, 4] = turns[5, 5]
    drive = np.cos(x.q)
    data = tmp_path / "clone" / tx40_nantes.EXAMPLE / "data"
    written(data / "pos_read_data.csv", {f"Joint_{j + 1}": (x.q @ turns.T)[:, j] for j in range(6)})
    written(data / "curr_data.csv", {f"Joint_{j + 1}": drive[:, j] for j in range(6)})
    folder = tmp_path / "out"
    folder.mkdir()
    logs = tx40_nantes.logs(tmp_path / "clone", folder)
    parts = [pd.read_csv(log.path) for log in logs]
    joined = pd.concat(parts)
    assert joined["t"].is_monotonic_increasing
    q, tau = (joined[[f"{c}_{j + 1}" for j in range(6)]].to_numpy() for c in ("q", "tau"))
    np.testing.assert_allclose(q, x.q + tx40_nantes.ZERO, atol=1e-9)
    np.testing.assert_allclose(
        np.sum(tau * x.dq, axis=1), np.sum(drive * (x.dq @ turns.T), axis=1), rtol=1e-9
    )


def test_what_repeats_a_sealed_stretch_is_never_fitted(tmp_path):
    t = np.arange(0, 21, 0.02)
    x = motion(t, 7)
    folder = tmp_path / "clone" / panda_rome.LOGS
    folder.mkdir(parents=True)
    for name, values in (("time", t), ("positions", x.q), ("velocity", x.dq), ("torques", x.ddq)):
        np.savetxt(folder / f"exciting_traj_{name}.txt", np.ravel(values))
    logs = panda_rome.logs(tmp_path / "clone", tmp_path)
    times = {log.role: [] for log in logs}
    for log in logs:
        times[log.role] += list(pd.read_csv(log.path)["t"])
    assert sum(map(len, times.values())) == len(t)
    phases = {role: np.mod(values, panda_rome.PERIOD) for role, values in times.items()}
    assert phases["estimation"].max() < phases["test"].min()
    assert phases["validation"].max() < phases["test"].min()
    np.testing.assert_allclose(
        pd.read_csv(logs[0].path)["tau_7"], x.ddq[t < panda_rome.PARTS[0][3], 6], atol=1e-12
    )


def test_the_second_motion_of_the_manipulator_is_sealed_whole(tmp_path):
    t = np.arange(0, 5, 1 / psm_worcester.RATE)
    folder = tmp_path / "clone" / psm_worcester.DATA
    folder.mkdir(parents=True)
    first, second = (motion(t, 7, seed) for seed in range(2))
    for name, x in (("one", first), ("two", second)):
        rows = np.hstack([0.1 * x.q + 0.15, 0.1 * x.dq, x.ddq])
        np.savetxt(folder / f"{name}_results.csv", rows, delimiter=",")
    dataset = psm_worcester.ARM.imported(tmp_path / "clone", tmp_path / "out")
    by_role = {r.role: r for r in dataset.recordings}
    assert [joint.unit("N m") for joint in dataset.robot.joints] == ["N m", "N m", "N"]
    assert len(by_role["test"].t) == len(t)
    np.testing.assert_allclose(by_role["test"].tau, second.ddq[:, :3])
    assert by_role["estimation"].t[-1] < by_role["validation"].t[0]


def test_a_table_of_base_parameters_is_a_robot_with_their_torque(tmp_path):
    robot = imi_scara()
    base = base_parameters(TorqueModel.standard(robot))
    rng = np.random.default_rng(3)
    count = base.regrouping.shape[1]
    values = rng.normal(size=count)
    table = tmp_path / "table.csv"
    renamed = {"Fc": "fs", "Fv": "fv"}
    with table.open("w", newline="") as file:
        for name, value in zip(base.names, base.from_standard(values), strict=True):
            symbol, joint = name.rsplit("_", 1)
            text = f"{renamed.get(symbol, symbol)}{int(joint) + 4} + 1.0*m9"
            csv.writer(file).writerow([text, value, 0.5])
    x = motion(np.arange(0, 2, 0.01), 2)
    model = TorqueModel.standard(robot)
    found = torque_of_table(robot, read_table(table, first=5))(x)
    np.testing.assert_allclose(found, model.torque(values, x), atol=1e-9)
    table.write_text("no parameter here\n")
    with pytest.raises(ValueError, match="line 1"):
        read_table(table, first=1)


def test_published_code_is_compiled_and_its_coriolis_terms_are_those_of_its_mass_matrix(tmp_path):
    if shutil.which("g++") is None:
        pytest.skip("no C++ compiler")
    a, b, c = 1.3, 0.4, 0.3
    code = tmp_path / "arm.cpp"
    code.write_text(
        "#include <cmath>\nvoid mass(const double* q, double* M) { double d = 0.3 * std::cos(q[1]);"
        "M[0] = 1.3 + 2 * d; M[1] = M[2] = 0.4 + d; M[3] = 0.4; }\n"
    )
    wrapper = (
        "void mass(const double*, double*);\n"
        'extern "C" void inertia(const double* q, double* out) { mass(q, out); }\n'
    )
    library = compiled([code], [], wrapper, tmp_path / "made")
    nothing = np.zeros_like
    torque = equation_of_motion(lambda q: library.call("inertia", 4, q), nothing, nothing)
    x = motion(np.arange(0, 1, 0.01), 2)
    (w1, w2), (a1, a2) = x.dq.T, x.ddq.T
    turn, sway = c * np.cos(x.q[:, 1]), c * np.sin(x.q[:, 1])
    expected = [
        (a + 2 * turn) * a1 + (b + turn) * a2 - sway * (2 * w1 + w2) * w2,
        (b + turn) * a1 + b * a2 + sway * w1**2,
    ]
    np.testing.assert_allclose(torque(x), np.transpose(expected), atol=1e-5)
    code.write_text("this is no code\n")
    with pytest.raises(NoCompiler, match="was not compiled"):
        compiled([code], [], wrapper, tmp_path / "made")


def test_an_arm_without_a_clone_has_a_line_that_says_how_to_get_it(tmp_path):
    out = tmp_path / "out"
    assert study.main(["--out", str(out), "--smoke"]) == 1
    rows = read_csv(out / "runs.csv")
    assert {row["arm"] for row in rows} == set(ARMS)
    for row in rows:
        assert f"git clone https://github.com/{ARMS[row['arm']].repository}" in row["status"]
    assert "TX40 (Nantes): failed" in (out / "summary.md").read_text()


def test_a_clone_is_diagnosed_and_its_sealed_rows_are_judged(tmp_path):
    pendulum(tmp_path / "clone")
    out = tmp_path / "out"
    given = [
        "--repo",
        str(tmp_path / "clone"),
        "--out",
        str(out),
        "--reports",
        str(tmp_path / "reports"),
    ]
    assert study.main([*given, "--smoke"]) == 0
    (row,) = [r for r in read_csv(out / "runs.csv") if r["arm"] == pendulum_dfki.ARM.name]
    assert row["status"] == "done"
    # The torque is a weight at each joint and viscous friction: that has a rigid body, but the published
    # numbers are of another.
    assert row["relative_base"] < 0.2 < row["relative_peer"]


def test_a_clone_is_found_by_what_it_holds_also_in_a_folder_of_clones(tmp_path):
    clone = tmp_path / "clones" / "anything"
    pendulum(clone)
    assert clone_of(pendulum_dfki.ARM.marker, [tmp_path / "clones"]) == clone
    assert clone_of(pendulum_dfki.ARM.marker, [clone]) == clone
    assert clone_of(tx40_nantes.ARM.marker, [clone]) is None
    with pytest.raises(ValueError, match="nowhere: no such folder"):
        study.main(["--repo", str(tmp_path / "nowhere"), "--out", str(tmp_path / "out")])


def test_bodies_are_fitted_without_the_sealed_recordings(tmp_path, monkeypatch):
    # That the search sees none of them is held by the tests of the diagnosis.
    seen = []

    def stop(dataset, **_):
        seen.extend(r.role for r in dataset.recordings)
        raise NoCompiler("far enough")

    monkeypatch.setattr(judge, "prepare_estimate", stop)
    case = judge.Case("arm", "1", 1.0, 0, smoke=True, place=tmp_path, reports=tmp_path)
    with pytest.raises(NoCompiler):
        judge.feasible_beside(case, data_set(0, repetitions=1))
    assert set(seen) == {"estimation", "validation"}


def test_a_user_s_data_set_stands_beside_the_public_ones_and_a_fault_is_a_line(tmp_path):
    broken = tmp_path / "data" / "broken"
    broken.mkdir(parents=True)
    (broken / "dataset.toml").write_text("format = 2\n")
    given = ["--data", str(tmp_path / "data"), "--out", str(tmp_path / "out"), "--smoke"]
    assert study.main(given) == 1
    (row,) = [r for r in read_csv(tmp_path / "out" / "runs.csv") if r["arm"] == "broken"]
    assert row["status"].startswith("failed: DataSetError")
    assert not study.Options(data=tmp_path).is_kept


def test_errors_are_those_of_the_rows_and_intervals_hold_them():
    rng = np.random.default_rng(0)
    torque = rng.normal(size=(400, 2)) * [3.0, 1.0]
    band = SimpleNamespace(analysis_rate=20.0)
    rows = cast(Prepared, SimpleNamespace(valid=np.ones(400, dtype=bool), torque=torque, band=band))
    ours = rng.normal(size=(400, 2)) * 0.1
    found = compare({"loop": [ours], "peer": [2 * ours]}, [rows], rng, ours="loop")
    assert found.relative["loop"] == pytest.approx(np.sqrt((ours**2).sum() / (torque**2).sum()))
    low, high = found.interval["loop"]
    assert low < found.relative["loop"] < high
    assert found.ratio["peer"] == pytest.approx((0.5, 0.5))


def test_rows_beyond_the_fitted_range_are_counted():
    fitted = np.linspace(-1, 1, 101)[:, None]
    sealed = np.array([[0.0], [1.03], [1.2], [-1.5]])
    assert beyond([fitted], [sealed]) == pytest.approx([0.5])
