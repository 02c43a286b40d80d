"""The identification study, as a user runs it."""

import json
from pathlib import Path

import numpy as np
import pytest

from oed.commands.from_data_set import prepare
from oed.commands.identify import estimate
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.experiment.dataset import DataSet
from oed.experiment.recording import Recording, Role
from oed.experiment.write_dataset import write_dataset
from oed.robot import imi_scara
from oed.robot.builtin import IMI_COULOMB, IMI_VISCOUS
from tests.diagnosis.arm import data_set
from tests.paths import SHARED_DATA, needs_shared_data
from tests.running import oed

NOISE = (0.05, 0.02)  # [N m]
WIDTH = 0.02  # [rad/s] of the true Coulomb terms' sign, the study's default
# Relative rms that plain least squares reaches, from the README of the recordings.
PUBLISHED: dict[str, dict[Role, list[float]]] = {
    "dfki_a0": {"estimation": [0.071, 0.147], "validation": [0.092, 0.156]},
    "staubli_tx40": {
        "estimation": [0.044, 0.042, 0.072, 0.080, 0.375, 0.260],
        "validation": [0.065, 0.060, 0.097, 0.112, 0.809, 0.367],
    },
    "franka_panda": {
        "estimation": [0.090, 0.011, 0.020, 0.010, 0.070, 0.057, 0.175],
        "validation": [0.160, 0.014, 0.059, 0.016, 0.290, 0.115, 0.189],
    },
}


def _simulated(folder: Path, rng: np.random.Generator) -> dict[str, float]:
    """Write a data set made from a known model; return its base parameters by expression."""
    model = build_model("standard", imi_scara(), sign_width=WIDTH)
    friction = [x for pair in zip(IMI_COULOMB, IMI_VISCOUS, strict=True) for x in pair]
    truth = np.concatenate([imi_scara().parameters, friction])
    recordings = []
    roles: dict[str, Role] = {"fit": "estimation", "held": "validation"}
    for name, role in roles.items():
        motion = _motion(rng)
        noise = rng.normal(size=motion.q.shape) * NOISE
        torque = model.torque(truth, motion) + noise
        recordings.append(Recording(name, role, motion.t, motion.q, torque))
    dataset = DataSet(
        name="simulated",
        source="tests",
        licence="none",
        robot=imi_scara(),
        torque="measured",
        recordings=tuple(recordings),
    )
    write_dataset(dataset, folder)
    base = base_parameters(model)
    return dict(zip(base.names, base.from_standard(truth), strict=True))


def _motion(rng: np.random.Generator) -> Motion:
    t = np.arange(0.0, 30.0, 0.002)
    w = 2 * np.pi * rng.uniform(0.1, 0.6, (2, 4))
    a = rng.uniform(0.1, 0.3, (2, 4))
    phase = t[:, None, None] * w + rng.uniform(0, 2 * np.pi, (2, 4))
    return Motion(
        t,
        (a * np.sin(phase)).sum(2),
        (a * w * np.cos(phase)).sum(2),
        -(a * w**2 * np.sin(phase)).sum(2),
    )


def test_recovers_the_parameters_of_a_simulated_arm(tmp_path: Path) -> None:
    truth = _simulated(tmp_path / "data", np.random.default_rng(21))
    arguments = ["identify", str(tmp_path / "data"), "--out", str(tmp_path / "out")]
    assert oed(*arguments, "--model", "standard") == 0
    record = json.loads((tmp_path / "out" / "estimate.json").read_text())
    assert {p["name"] for p in record["parameters"]} == set(truth)
    for parameter in record["parameters"]:
        # The low-pass rounds the Coulomb steps a little: a bias of 1 % at most.
        assert parameter["value"] == pytest.approx(truth[parameter["name"]], rel=0.01, abs=2e-3)
    # Noise in the band that the low-pass leaves: the residual must come down to it.
    share = 2 * record["settings"]["processing"]["cutoff"] / 500.0
    assert record["rms"]["validation"] == pytest.approx(np.array(NOISE) * share**0.5, rel=0.3)


def test_gaps_of_the_log_are_told_and_cost_no_accuracy(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = _simulated(tmp_path / "data", np.random.default_rng(27))
    file = tmp_path / "data" / "fit.csv"
    header, *lines = file.read_text().splitlines()
    t = np.array([float(line.split(",")[0]) for line in lines])
    missing = ((t > 6) & (t < 7.5)) | ((t > 15) & (t < 15.8)) | ((t > 22) & (t < 23.3))
    kept = [line for line, gone in zip(lines, missing, strict=True) if not gone]
    file.write_text("\n".join([header, *kept]) + "\n")
    out = tmp_path / "out"
    assert oed("identify", str(tmp_path / "data"), "--out", str(out), "--model", "standard") == 0
    assert "fit: 3 gap(s)" in capsys.readouterr().out
    assert "3 gap(s)" in (out / "report.html").read_text()
    record = json.loads((out / "estimate.json").read_text())
    assert record["gaps"]["fit"]["gaps"] == 3
    assert record["gaps"]["fit"]["total_s"] == pytest.approx(3.6, abs=0.02)
    processing = record["settings"]["processing"]
    rate = processing["rate"] / processing["decimation"]
    counted = record["samples"]["estimation"] / rate
    assert counted == pytest.approx(30.0 - 3.6 - 8 * processing["trim"], abs=0.1)
    for parameter in record["parameters"]:
        assert parameter["value"] == pytest.approx(truth[parameter["name"]], rel=0.01, abs=2e-3)
    share = 2 * processing["cutoff"] / 500.0
    assert record["rms"]["estimation"] == pytest.approx(np.array(NOISE) * share**0.5, rel=0.3)


def test_leaves_everything_that_it_promises(tmp_path: Path) -> None:
    _simulated(tmp_path / "data", np.random.default_rng(22))
    out = tmp_path / "out"
    assert oed("identify", str(tmp_path / "data"), "--out", str(out)) == 0
    record = json.loads((out / "estimate.json").read_text())
    promised = {
        "format", "data", "joints", "samples", "parameters", "unidentifiable", "condition",
        "rms", "relative_rms", "settings", "versions", "seed",
    }  # fmt: skip
    assert promised <= set(record)
    assert set(record["condition"]) >= {"J_k", "J_d_log10", "rows"}
    for parameter in record["parameters"]:
        low, high = parameter["interval95"]
        assert low < parameter["value"] < high
    for name in ("report.html", "parameters.csv", "validation_errors.csv"):
        assert (out / name).stat().st_size > 0
    assert not list(out.glob("*.png"))
    page = (out / "report.html").read_text(encoding="utf-8")
    assert str(tmp_path) not in page
    # 15 kg and 6 kg about vertical axes.
    assert record["total_mass"]["file"] == pytest.approx(21.0)
    assert "Total mass of what moves: 21 kg in the robot&#39;s file. None is identified" in page
    (izz_2,) = (p for p in record["parameters"] if p["name"] == "Izz_2")
    assert izz_2["file"] == pytest.approx(0.141)  # the paper's
    friction = {p["file"] for p in record["parameters"] if p["name"].startswith("F")}
    assert friction == {None}


def test_a_motionless_joint_is_named_and_not_given_numbers(tmp_path: Path) -> None:
    rng = np.random.default_rng(23)
    motion = _motion(rng)
    still = Motion(motion.t, motion.q * [1, 0], motion.dq * [1, 0], motion.ddq * [1, 0])
    model = build_model("standard", imi_scara(), sign_width=WIDTH)
    truth = np.concatenate([imi_scara().parameters, [2.0, 7.0, 1.0, 0.7]])
    torque = model.torque(truth, still) + rng.normal(size=still.q.shape) * NOISE
    recording = Recording("fit", "estimation", still.t, still.q, torque)
    dataset = DataSet("still", "tests", "none", imi_scara(), "measured", recordings=(recording,))
    write_dataset(dataset, tmp_path / "data")
    out = tmp_path / "out"
    code = oed("identify", str(tmp_path / "data"), "--out", str(out), "--model", "standard")
    assert code == 0
    record = json.loads((out / "estimate.json").read_text())
    assert {"Fc_2", "Fv_2"} <= set(record["unidentifiable"])
    assert not {"Fc_2", "Fv_2"} & {p["name"] for p in record["parameters"]}


def test_what_cannot_be_right_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _simulated(tmp_path / "data", np.random.default_rng(28))
    arguments = ["identify", str(tmp_path / "data"), "--out", str(tmp_path / "out")]
    assert oed(*arguments, "--model", "standard") == 0
    assert json.loads((tmp_path / "out" / "estimate.json").read_text())["doubts"] == []
    assert "they cannot be" not in capsys.readouterr().out
    for name in ("fit.csv", "held.csv"):
        file = tmp_path / "data" / name
        table = np.loadtxt(file, delimiter=",", skiprows=1)
        header = file.read_text().splitlines()[0]
        table[:, header.split(",").index("tau_2")] *= -1
        np.savetxt(file, table, delimiter=",", header=header, comments="", fmt="%.17g")
    assert oed(*arguments, "--model", "standard") == 0
    told = [line for line in capsys.readouterr().out.splitlines() if line.startswith("note: ")]
    assert "the sign of the torque of joint_2 (tau_2) is reversed" in told[0]
    assert any("Fv_2 = -" in line and "they cannot be" in line for line in told)
    record = json.loads((tmp_path / "out" / "estimate.json").read_text())
    assert record["cause"]["kind"] == "sign"
    assert len(record["doubts"]) == len(told)


def test_a_joint_whose_encoder_only_flickers_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(31)
    _simulated(tmp_path / "data", rng)
    for name in ("fit.csv", "held.csv"):
        file = tmp_path / "data" / name
        table = np.loadtxt(file, delimiter=",", skiprows=1)
        header = file.read_text().splitlines()[0]
        table[:, header.split(",").index("q_2")] = 0.1 + 1e-5 * rng.normal(size=len(table))
        np.savetxt(file, table, delimiter=",", header=header, comments="", fmt="%.17g")
    arguments = ["identify", str(tmp_path / "data"), "--out", str(tmp_path / "out")]
    assert oed(*arguments) == 0
    assert "does not move in the recordings for estimation: joint_2" in capsys.readouterr().out


def test_bad_input_is_one_line_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _simulated(tmp_path / "data", np.random.default_rng(24))
    file = tmp_path / "data" / "fit.csv"
    lines = file.read_text().splitlines()
    lines[100] = lines[100].replace(lines[100].split(",")[2], "1e30")
    file.write_text("\n".join(lines) + "\n")
    out = tmp_path / "out"
    assert oed("identify", str(tmp_path / "data"), "--out", str(out)) == 2
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    assert "fit.csv" in message
    assert "101" in message
    assert not out.exists()


def test_a_cutoff_that_the_data_cannot_carry_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _simulated(tmp_path / "data", np.random.default_rng(25))
    out = tmp_path / "out"
    arguments = ["identify", str(tmp_path / "data"), "--out", str(out), "--cutoff", "400"]
    assert oed(*arguments) == 2
    assert "400" in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize("cutoff", ["0", "-1", "nan", "inf"])
def test_a_cutoff_that_is_no_frequency_is_refused_by_name(
    cutoff: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _simulated(tmp_path / "data", np.random.default_rng(26))
    arguments = ["identify", str(tmp_path / "data"), "--out", str(tmp_path / "out")]
    assert oed(*arguments, "--cutoff", cutoff) == 2
    assert f"--cutoff {cutoff}" in capsys.readouterr().err


def test_an_out_that_is_a_file_is_refused_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    taken = tmp_path / "taken"
    taken.touch()
    assert oed("identify", str(tmp_path / "absent"), "--out", str(taken)) == 2
    assert "is a file" in capsys.readouterr().err


@needs_shared_data
@pytest.mark.parametrize("name", PUBLISHED)
def test_reaches_what_plain_least_squares_reaches_on_measured_data(
    name: str, tmp_path: Path
) -> None:
    calibration = estimate(prepare(SHARED_DATA / name, model="rotor"), robust=False)
    for role, published in PUBLISHED[name].items():
        reached = calibration.validation[role].relative_rms
        # The bands are not the published ones; all joints together must not be worse for that.
        shares = reached / np.array(published)
        assert np.exp(np.mean(np.log(shares))) <= 1.0, (role, reached)
        assert (shares <= 1.12).all(), (role, reached)


@needs_shared_data
def test_the_panda_with_offsets_beats_the_published_error(tmp_path: Path) -> None:
    data = SHARED_DATA / "franka_panda"
    calibration = estimate(prepare(data, model="offset"), robust=False)
    assert calibration.validation["estimation"].overall_relative_rms <= 0.0115  # published: 0.0141


def test_the_noise_is_the_same_whichever_model_is_asked_for():
    dataset = data_set(35, repetitions=1)
    floors = [
        estimate(prepare(dataset, model=name), robust=False).noise_floor
        for name in (None, "standard", "rotor")
    ]
    for floor in floors[1:]:
        np.testing.assert_array_equal(floor, floors[0])
