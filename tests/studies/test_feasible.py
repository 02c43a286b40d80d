"""Feasible identification and the study of its price, as a user runs them."""

import dataclasses
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

from oed.commands.configurations import Feasible
from oed.commands.feasible import estimate, settings_of
from oed.commands.from_data_set import prepare_for
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.estimation.calibration import calibrate
from oed.estimation.feasible.calibration import validate_parameters
from oed.estimation.feasible.data_factor import JointFactors, block_factors
from oed.estimation.feasible.estimate import estimate_feasible
from oed.estimation.feasible.regularisation import Regularisation
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.settings import choose_settings
from oed.experiment.read_dataset import read_dataset
from oed.experiment.recording import Recording, Role
from oed.experiment.write_dataset import write_dataset
from oed.report.feasible_rows import solver_comparison
from oed.report.table import read_csv
from oed.robot import imi_scara
from oed.robot.builtin import IMI_COULOMB, IMI_VISCOUS
from studies import feasibility_price
from tests.paths import SHARED_CASES, SHARED_DATA, needs_shared_data
from tests.running import oed

GAZ = 0.0141  # overall relative error of Gaz and others 2019, supplementary material, table III


def motion_of(rng: np.random.Generator) -> Motion:
    t = np.arange(0.0, 20.0, 0.005)
    w, a = 2 * np.pi * rng.uniform(0.1, 0.6, (2, 4)), rng.uniform(0.1, 0.3, (2, 4))
    phase = t[:, None, None] * w + rng.uniform(0, 2 * np.pi, (2, 4))
    return Motion(
        t,
        (a * np.sin(phase)).sum(2),
        (a * w * np.cos(phase)).sum(2),
        (-a * w**2 * np.sin(phase)).sum(2),
    )


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    rng = np.random.default_rng(31)
    robot = imi_scara()
    model = build_model("standard", robot, sign_width=0.02)
    friction = np.column_stack([IMI_COULOMB, IMI_VISCOUS]).reshape(-1)
    truth = np.concatenate([robot.parameters, friction])
    recordings = []
    roles: dict[str, Role] = {"fit": "estimation", "held": "validation"}
    for name, role in roles.items():
        motion = motion_of(rng)
        torque = model.torque(truth, motion) + rng.normal(size=motion.q.shape) * (0.05, 0.02)
        recordings.append(Recording(name, role, motion.t, motion.q, torque))
    folder = tmp_path_factory.mktemp("simulated")
    write_dataset(
        DataSet("simulated", "tests", "none", robot, "measured", recordings=tuple(recordings)),
        folder,
    )
    return folder


@pytest.fixture(scope="module")
def results(simulated: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("out")
    assert oed("feasible", str(simulated), "--out", str(out), "--smoke", "--model", "standard") == 0
    return out


def test_leaves_everything_that_it_promises(results: Path) -> None:
    names = {path.name for path in results.iterdir()}
    assert {
        "estimate.json",
        "parameters.yaml",
        "calibrated_robot.urdf",
        "calibrated_robot.sdf",
        "calibrated_robot.xml",
        "report.html",
    } <= names
    page = (results / "report.html").read_text(encoding="utf-8")
    assert "positive definite in 100 %" in page
    assert str(results) not in page
    assert not list(results.glob("*.png"))


def test_the_record_states_its_proofs(results: Path) -> None:
    record = json.loads((results / "estimate.json").read_text(encoding="utf-8"))
    assert record["mass_matrix"]["positive_definite"] == 1.0
    assert record["solver"]["relative_difference"] < 1e-6
    assert all(link["per reference"] > 0 for link in record["links"])
    assert all(row["Drake"] < 1e-9 for row in record["exports"])
    decided = [row for row in record["parameters"] if row["from_data"] > 0.5]
    assert 0 < len(decided) < len(record["parameters"])
    for row in decided:
        assert row["lower95"] <= row["value"] <= row["upper95"]
    assert all(row["lower95"] is None for row in record["parameters"] if row not in decided)
    held = [r for r in record["validation"] if r["recordings"] == "validation"]
    assert held[-1]["price [%]"] < 2.0


def test_well_determined_parameters_are_the_true_ones(results: Path) -> None:
    rows = {row["name"]: row for row in read_csv(results / "parameters.csv")}
    for name, true in (("Fc_1", IMI_COULOMB[0]), ("Fv_2", IMI_VISCOUS[1]), ("mx_2", 0.808)):
        assert rows[name]["value"] == pytest.approx(true, rel=0.02)
        assert rows[name]["from_data"] > 0.9
    # No torque of this arm depends on the mass of a link: the reference decides.
    assert rows["m_1"]["from_data"] < 1e-3
    written = yaml.safe_load((results / "parameters.yaml").read_text(encoding="utf-8"))
    assert written["parameters"]["joint_1"]["Fc_1"]["value"] == pytest.approx(rows["Fc_1"]["value"])
    assert "interval" in written["parameters"]["joint_1"]["Fc_1"]
    assert "interval" not in written["parameters"]["joint_1"]["m_1"]


def test_a_bound_is_marked_and_its_intervals_are_explained(simulated: Path, tmp_path: Path) -> None:
    # This arm has no rotors: zero bounds what noise makes of them.
    given = ["feasible", str(simulated), "--out", str(tmp_path), "--smoke"]
    assert oed(*given, "--model", "rotor", "--weight", "1e-6") == 0
    record = json.loads((tmp_path / "estimate.json").read_text(encoding="utf-8"))
    marked = {row["name"] for row in record["parameters"] if row["at_bound"]}
    assert marked == {"Ia_2"}
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "not how far the truth may be" in page


def test_a_prior_and_a_total_mass_are_obeyed(simulated: Path, tmp_path: Path) -> None:
    options = ["--smoke", "--model", "standard", "--prior", "file", "--weight", "1e-3"]
    given = ["feasible", str(simulated), "--out", str(tmp_path), "--total-mass", "20"]
    assert oed(*given, *options) == 0
    rows = {row["name"]: row for row in read_csv(tmp_path / "parameters.csv")}
    assert rows["m_1"]["value"] + rows["m_2"]["value"] == pytest.approx(20.0)


def test_a_failed_comparison_of_solvers_does_not_read_as_a_failed_estimate(simulated: Path) -> None:
    config = Feasible(data=simulated, out=simulated, model="standard", weight=1e-3, smoke=True)
    prepared = prepare_for(config)
    result = estimate(prepared, settings_of(config, prepared.model))
    assert solver_comparison(result).startswith("Objectives of the two solvers differ by")
    alone = dataclasses.replace(result, second=None, second_failure="barrier: 60 Newton steps")
    told = solver_comparison(alone)
    assert told.startswith("Solved by clarabel")
    assert "barrier: 60 Newton steps" in told
    assert "None" not in told


def test_a_pause_of_the_log_is_on_the_page_and_in_the_record(
    simulated: Path, tmp_path: Path
) -> None:
    shutil.copytree(simulated, tmp_path / "data")
    file = tmp_path / "data" / "held.csv"
    lines = file.read_text().splitlines()
    file.write_text("\n".join([*lines[:1001], *lines[1401:]]) + "\n")
    out = tmp_path / "out"
    given = ["feasible", str(tmp_path / "data"), "--out", str(out), "--smoke"]
    assert oed(*given, "--model", "standard", "--weight", "1e-3") == 0
    assert "held: 1 gap(s)" in (out / "report.html").read_text(encoding="utf-8")
    assert json.loads((out / "estimate.json").read_text())["gaps"]["held"]["gaps"] == 1


def test_bad_input_is_one_line(
    simulated: Path, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    out = tmp_path / "out"
    given = ["feasible", str(simulated), "--out", str(out), "--smoke", "--collision"]
    assert oed(*given) == 2
    assert "collision geometry" in capsys.readouterr().err
    assert not out.exists()


def test_the_price_study_runs_and_shows_its_point(tmp_path: Path) -> None:
    feasibility_price.main(["--smoke", "--out", str(tmp_path)])
    rows = read_csv(tmp_path / "runs.csv")
    plain, feasible, informed = rows
    assert [row["estimator"] for row in rows] == ["plain", "feasible", "feasible, prior"]
    assert feasible["positive_definite"] == informed["positive_definite"] == 1.0
    assert feasible["feasible_robot"] is True
    assert plain["estimation_rms"] <= feasible["estimation_rms"]
    assert feasible["validation_error"] < plain["validation_error"]
    assert (tmp_path / "provenance.json").is_file()


def test_every_experiment_of_the_price_study_is_another_draw() -> None:
    config = dataclasses.replace(feasibility_price.SMOKE, repeats=2)
    cases = feasibility_price.cases_of(config)
    assert len({case.key for case in cases}) == len(cases) == 6
    conditions = [feasibility_price.work(case)["condition"] for case in cases[::3]]
    assert len(set(conditions)) == 2


def test_the_accuracy_and_the_changes_are_in_the_record_and_on_the_page(
    simulated: Path, tmp_path: Path
) -> None:
    given = ["feasible", str(simulated), "--out", str(tmp_path), "--smoke", "--model", "standard"]
    assert oed(*given, "--weight", "1e-3", "--prior", "file") == 0
    record = json.loads((tmp_path / "estimate.json").read_text(encoding="utf-8"))
    assert record["accuracy"]["is_accurate"] is True
    assert 0 < record["accuracy"]["reached"] < 1e-6
    assert record["accuracy"]["feasibility_margin"] > 0
    assert [row["link"] for row in record["changes_from_file"]][-1] == "all links"
    # No torque of this arm depends on its masses: they are the file's.
    for row in record["changes_from_file"]:
        assert row["change [%]"] == pytest.approx(0.0, abs=1.0)
        assert row["data alone +- [kg]"] is None
        assert row["beyond reason"] == ""
    assert record["warnings"] == []
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "of its optimum, relatively; all demands are met" in page


def test_a_mass_beyond_reason_is_told_with_the_files(simulated: Path, tmp_path: Path) -> None:
    given = ["feasible", str(simulated), "--out", str(tmp_path), "--smoke", "--model", "standard"]
    # A total that the file contradicts, on masses that no torque decides.
    assert oed(*given, "--weight", "1e-3", "--prior", "file", "--total-mass", "300") == 0
    record = json.loads((tmp_path / "estimate.json").read_text(encoding="utf-8"))
    total = record["changes_from_file"][-1]
    assert total["identified [kg]"] == pytest.approx(300.0, rel=1e-6)
    assert total["beyond reason"] == "mass"
    assert any("all links: mass 300 kg, in the file" in warning for warning in record["warnings"])
    assert "believe the file" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_copy_among_the_held_out_is_noted_beside_its_good_error(
    simulated: Path, tmp_path: Path
) -> None:
    shutil.copytree(simulated, tmp_path / "data")
    shutil.copy(tmp_path / "data" / "fit.csv", tmp_path / "data" / "held.csv")
    out = tmp_path / "out"
    given = ["feasible", str(tmp_path / "data"), "--out", str(out), "--smoke"]
    assert oed(*given, "--model", "standard", "--weight", "1e-3") == 0
    record = json.loads((out / "estimate.json").read_text(encoding="utf-8"))
    assert any("moving rows from fit" in note for note in record["doubts"])
    assert "Note on the data" in (out / "report.html").read_text(encoding="utf-8")


MED7 = SHARED_CASES / "feasible_no_solver_med7"


@pytest.mark.skipif(not MED7.is_dir(), reason="the cases (../shared/cases) are not on this machine")
def test_a_short_log_of_a_seven_joint_arm_gives_masses_near_its_files(tmp_path: Path) -> None:
    assert oed("feasible", MED7, "--out", tmp_path, "--smoke") == 0
    record = json.loads((tmp_path / "estimate.json").read_text(encoding="utf-8"))
    assert record["accuracy"]["is_accurate"] is True
    masses = [row["identified [kg]"] for row in record["changes_from_file"]]
    assert 10 < masses[-1] < 35  # the file's are 18.6 kg, the makers state 22 kg with the base
    assert max(masses[:-1]) < 10
    # Half as heavy again as in the file, which no torque in this log asks for.
    beyond = [r["link"] for r in record["changes_from_file"] if "mass" in r["beyond reason"]]
    assert beyond == ["link_4", "link_7"]
    assert any("link_7: mass 0.7" in warning for warning in record["warnings"])
    held = [r for r in record["validation"] if r["recordings"] == "validation"][-1]
    assert held["feasible rms / torque rms"] < 0.22  # plain least squares: 0.42


@needs_shared_data
def test_a_feasible_panda_beats_the_published_error_of_its_makers() -> None:
    dataset = read_dataset(SHARED_DATA / "franka_panda")
    model = build_model("rotor", dataset.robot, sign_width=0.02)
    # The logged velocity is what `choose_velocity` takes for this set.
    settings = dataclasses.replace(
        choose_settings(dataset.recordings, cutoff=8.0), velocity="logged"
    )
    plain = calibrate(dataset, model, settings)
    blocks = block_factors(model, plain.recordings["estimation"], blocks=1)
    data = JointFactors.join(blocks).weighted(plain.estimate.joint_variances)
    estimate = estimate_feasible(model, data, regularisation=Regularisation(1e-4))
    assert estimate.relative_margins.min() > 0
    every = tuple(r for recordings in plain.recordings.values() for r in recordings)
    # The whole recording, of which the estimate has seen the estimation part alone.
    assert validate_parameters(model, estimate.parameters, every).overall_relative_rms < GAZ
