"""The motion that `oed design` finds, as a user runs it."""

import contextlib
import io
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio
import pytest

from oed.design.limits import Certificate
from oed.design.problem import DesignProblem
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.robot import imi_scara
from tests.design.primitive_arm import arm_and_post, elbow_at, planar_arm, to_post
from tests.running import oed
from tests.studies.designed import designed, experiment_information, log10_det


@pytest.fixture(scope="module")
def scara(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, pd.DataFrame, Path]:
    """Record, motion and folder of a quick design with no wishes, of an arm without shapes."""
    out = tmp_path_factory.mktemp("scara") / "out"
    return *designed(out, "--robot", "builtin:imi_scara"), out


@pytest.fixture(scope="module")
def beside_post(
    tmp_path_factory: pytest.TempPathFactory,
) -> tuple[dict, pd.DataFrame, str, Path]:
    """The same of an arm with shapes, 1000 set points a second; what it printed; the arm's file.

    Beside it is a post so thick that half of all postures hit it or are beyond it.
    """
    folder = tmp_path_factory.mktemp("post")
    arm_and_post(folder, post=0.35)
    file, printed = folder / "planar.urdf", io.StringIO()
    with contextlib.redirect_stdout(printed):
        found = designed(folder / "out", "--robot", str(file), "--rate", "1000")
    return *found, printed.getvalue(), file


def test_one_command_gives_a_motion_within_proven_limits(
    scara: tuple[dict, pd.DataFrame, Path],
) -> None:
    record, motion, _ = scara
    promised = {
        "format", "robot", "joints", "class", "coefficients", "horizon", "instants", "J_k",
        "J_k_continuous", "J_d_log10", "J_d_log10_continuous", "d_efficiency", "certified_max",
        "limits", "optimiser", "seed", "cpu_s", "status", "versions",
    }  # fmt: skip
    assert promised <= set(record)
    assert np.isfinite(record["J_k"])
    limits = imi_scara().limits
    for kind, prefix in (("position", "q"), ("velocity", "dq"), ("acceleration", "ddq")):
        proven = np.array(record["certified_max"][kind])
        for joint, name in enumerate(record["joints"]):
            # The file's digits may round a value up to the bound itself.
            assert motion[f"{prefix}_{name}"].abs().max() <= proven[joint] * (1 + 1e-6)
            assert proven[joint] <= getattr(limits, kind)[joint, 1] * (1 + 1e-12)


def test_rotor_inertias_are_excited_or_it_is_said_that_they_are_not(
    scara: tuple[dict, pd.DataFrame, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    without, _, out = scara
    rotors, _ = designed(tmp_path / "out", "--robot", "builtin:imi_scara", "--model", "rotor")
    assert "--model rotor" not in capsys.readouterr().out
    assert "--model rotor" in (out / "report.html").read_text(encoding="utf-8")
    for model, record in (("standard", without), ("rotor", rotors)):
        assert record["model"] == model
        assert ("Ia_2" in record["base_parameters"]) == (model == "rotor")
        assert ("--model rotor" in " ".join(record["notes"])) == (model == "standard")


def test_a_motion_at_rest_completes_an_earlier_experiment(
    scara: tuple[dict, pd.DataFrame, Path], tmp_path: Path
) -> None:
    first, _, out = scara
    assert first["with_prior"] is None
    earlier, wishes = out / "design.json", ("--robot", "builtin:imi_scara", "--horizon", "6")
    second, motion = designed(tmp_path / "second", *wishes, "--prior", str(earlier))
    rates = motion.filter(regex="^(dq|ddq)_").to_numpy()
    np.testing.assert_allclose(rates[[0, -1]], 0.0, atol=1e-9)
    assert (np.abs(rates).max(axis=0) > 0.1).all()
    assert motion["t"].iloc[-1] == 6.0
    assert second["prior"] == [str(earlier)]
    information = [experiment_information(record) for record in (first, second)]
    told = second["with_prior"]["J_d_log10"]
    assert told == pytest.approx(log10_det(information[0] + information[1]), abs=1e-6)
    assert second["J_d_log10"] == pytest.approx(log10_det(information[1]), abs=1e-6)


def dense_distance(file: Path, names: list[str], q: np.ndarray) -> float:
    """The least distance of links that no joint connects, by Pinocchio and Coal on the file."""
    model = pinocchio.buildModelFromUrdf(str(file))
    kind = pinocchio.GeometryType.COLLISION
    shapes = pinocchio.buildGeomFromUrdf(model, str(file), kind)
    shapes.addAllCollisionPairs()
    data, of_shapes = model.createData(), pinocchio.GeometryData(shapes)
    strangers = []
    for k, pair in enumerate(shapes.collisionPairs):
        a, b = (shapes.geometryObjects[i].parentJoint for i in (pair.first, pair.second))
        if a != b and model.parents[a] != b and model.parents[b] != a:
            strangers.append(k)
    order = [model.joints[model.getJointId(name)].idx_q for name in names]
    least = np.inf
    for posture in q:
        pinocchio.updateGeometryPlacements(model, data, shapes, of_shapes, posture[order])
        for k in strangers:
            least = min(least, pinocchio.computeDistance(shapes, of_shapes, k).min_distance)
    return least


def test_with_no_options_a_motion_can_be_sent_to_the_arm(
    beside_post: tuple[dict, pd.DataFrame, str, Path],
) -> None:
    record, motion, told, file = beside_post
    t = motion["t"].to_numpy()
    q = motion[["q_shoulder", "q_elbow"]].to_numpy()
    # Clear of itself, by closed form and by programs that the design does not use.
    assert to_post(q, 0.35).min() >= 0.01
    assert dense_distance(file, ["shoulder", "elbow"], q) >= 0.01
    # From rest to rest, and within 90 % of what the file allows, by differences alone.
    speed, rate = np.gradient(q, t, axis=0), np.gradient(np.gradient(q, t, axis=0), t, axis=0)
    assert np.abs(speed[[0, -1]]).max() < 0.02
    assert np.abs(rate[[2, -3]]).max() < 0.3
    assert np.abs(speed).max() <= 0.9 * 2.0 + 1e-4
    assert np.abs(speed).max() > 0.8 * 2.0
    assert np.abs(rate).max() <= 0.9 * 10.0 + 0.05  # ten: assumed, as the file states none
    columns = ["dq_shoulder", "dq_elbow", "ddq_shoulder", "ddq_elbow"]
    np.testing.assert_allclose(motion[columns].to_numpy()[[0, -1]], 0.0, atol=1e-9)
    assert np.ptp(q, axis=0).min() > 0.5
    assert "clear of itself: by 10 mm" in told or "clear of itself" in record["status"]
    assert "rest to rest" in told
    assert "90%" in told
    assert record["clearance"]["bodies"]["spare"] >= 0.0
    assert record["margin"] == 0.9
    assert record["before_clearance"]["J_d_log10"] > record["J_d_log10"] - 3.0


def test_every_safety_can_be_switched_off_and_that_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arm_and_post(tmp_path, post=0.35)
    record, motion = designed(
        tmp_path / "out", "--robot", str(tmp_path / "planar.urdf"),
        "--periodic", "--margin", "1", "--no-clearance",
    )  # fmt: skip
    truth = to_post(motion[["q_shoulder", "q_elbow"]].to_numpy(), 0.35).min()
    assert truth < 0.0
    assert record["clearance"]["bodies"]["least"] == pytest.approx(truth, abs=5e-3)
    assert record["clearance"]["bodies"]["pair"] == ["base", "lower"]
    assert np.abs(motion["dq_shoulder"].to_numpy(dtype=float)).max() > 0.95 * 2.0
    assert np.abs(motion.filter(regex="^dq_").to_numpy()[0]).max() > 0.1
    told = capsys.readouterr().out
    assert "given up: rest to rest; clear of itself: base and lower overlap by" in told
    assert "may start and end at speed" in told


def test_a_motion_is_slowed_down_on_the_same_way(
    beside_post: tuple[dict, pd.DataFrame, str, Path], tmp_path: Path
) -> None:
    full, fast, _, file = beside_post
    wishes = ("--robot", str(file), "--scale", "0.5", "--rate", "500")
    half, slow = designed(tmp_path / "half", *wishes)
    assert half["horizon"] == 2 * full["horizon"]
    for name in ("shoulder", "elbow"):
        np.testing.assert_allclose(slow[f"q_{name}"], fast[f"q_{name}"], atol=1e-9)
        np.testing.assert_allclose(slow[f"dq_{name}"], fast[f"dq_{name}"] / 2, atol=1e-9)
        np.testing.assert_allclose(slow[f"ddq_{name}"], fast[f"ddq_{name}"] / 4, atol=1e-9)
    proven = [np.array(record["certified_max"]["velocity"]) for record in (full, half)]
    np.testing.assert_allclose(proven[1], proven[0] / 2, rtol=1e-4)
    assert half["clearance"]["bodies"]["spare"] >= 0.0


def test_an_arm_on_a_wall_is_designed_for_its_own_gravity(tmp_path: Path) -> None:
    arm = planar_arm(tmp_path)  # its axes are vertical: gravity shows on a wall alone
    robot = ("--robot", str(tmp_path / "planar.urdf"), "--no-torque")
    wall, _ = designed(tmp_path / "wall", *robot, "--gravity", "0", "-9.81", "0")
    upright = base_parameters(TorqueModel.standard(arm))
    assert len(wall["base_parameters"]) > len(upright)
    assert wall["gravity"] == [0.0, -9.81, 0.0]


def test_a_box_is_kept_where_it_is_given(tmp_path: Path) -> None:
    planar_arm(tmp_path)
    walls = ("-0.2", "0.6", "-0.45", "0.4", "-1", "1")
    record, motion = designed(
        tmp_path / "out", "--robot", str(tmp_path / "planar.urdf"), "--box", *walls,
    )  # fmt: skip
    elbow = elbow_at(motion[["q_shoulder", "q_elbow"]].to_numpy())
    assert (elbow[:, 0] > -0.2).all()
    assert (elbow[:, 1] > -0.45).all()
    assert (elbow[:, 1] < 0.4).all()
    assert record["usable"]
    standing = {limit["limit"]: limit["standing"] for limit in record["asked"]}
    assert standing["the box"] == "proven"
    assert record["clearance"]["walls"]["spare"] >= 0.0


def test_what_cannot_be_shown_is_told_on_screen(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    planar_arm(tmp_path)
    record, _ = designed(tmp_path / "out", "--robot", str(tmp_path / "planar.urdf"))
    assert "note: drawn as lines" in capsys.readouterr().out
    assert "drawn as lines" in " ".join(record["notes"])
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert page.count("<iframe srcdoc=") == 1
    assert "drawn as lines" in page
    assert str(tmp_path) not in page
    assert f"{record['J_k']:.4g}" in page


FOR_A_CONTROLLER = ("motion.csv", "joint_trajectory.json", "joint_trajectory.yaml")


def test_nothing_for_a_controller_is_left_where_a_limit_is_not_kept(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    planar_arm(tmp_path)
    out = tmp_path / "out"
    wishes = ("--robot", str(tmp_path / "planar.urdf"))
    designed(out, *wishes)
    assert all((out / name).exists() for name in FOR_A_CONTROLLER)

    def careless(problem: DesignProblem, z: np.ndarray) -> tuple[np.ndarray, Certificate]:
        beyond = z + 10.0 * (np.arange(len(z)) == 0)
        return beyond, problem.certificate(beyond)

    monkeypatch.setattr("oed.design.design.prove", careless)
    capfd.readouterr()
    assert oed("design", *wishes, "--out", str(out), "--smoke") == 3
    printed = capfd.readouterr()
    assert "NOT usable: position: joint shoulder beyond its limit by" in printed.out
    assert "proven feasible" not in printed.out
    # Beside the progress, which is shown on a slow machine.
    assert printed.err.count("oed design: ") == 1
    record = json.loads((out / "design.json").read_text())
    assert not record["usable"]
    assert record["status"].startswith("NOT usable: position: joint shoulder")
    assert not any((out / name).exists() for name in FOR_A_CONTROLLER)
