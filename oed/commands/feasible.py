"""`oed feasible`: physically consistent parameters that explain an arm's torque, and their price."""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path

import numpy as np

from oed.checkup.checkup import check_calibration, doubts_of_data
from oed.commands.configurations import Feasible, ModelName, Prior
from oed.commands.from_data_set import Prepared, prepare, prepare_for
from oed.commands.from_log import imported
from oed.commands.telling import say, speak
from oed.counted import counted
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.calibration import calibrate
from oed.estimation.feasible.calibration import (
    FeasibleCalibration,
    FeasibleSettings,
    calibrate_feasibly,
)
from oed.estimation.feasible.collision_regions import collision_regions
from oed.estimation.feasible.feasible_set import FeasibleSet
from oed.estimation.feasible.reference import file_inertials
from oed.experiment.dataset import DataSet
from oed.export.calibrated_robot import CalibratedRobot
from oed.export.found_models import of_feasible
from oed.export.mjcf import write_mjcf
from oed.export.model_file import NAME as MODEL
from oed.export.model_file import write_model
from oed.export.parameter_file import ParameterTable, write_parameters
from oed.export.round_trip import require_round_trip, torque_by_pinocchio
from oed.export.sdf import write_sdf
from oed.export.urdf import write_urdf
from oed.one_thread import on_one_thread
from oed.report.feasible_report import write_feasible
from oed.report.feasible_rows import (
    change_rows,
    link_rows,
    solver_comparison,
    validation_rows,
)
from oed.report.provenance import Provenance
from oed.report.study_files import FEASIBLE
from oed.report.table import Row, text_table

ROUND_TRIP_SAMPLES = 200
# Of the file's inertials as what is pulled to; None where they decide by being plausible.
WANTED = {"auto": None, "file": True, "neutral": False}


@on_one_thread
def identify_feasible(
    data: DataSet | str | Path,
    *,
    model: ModelName | None = None,
    cutoff: float | None = None,
    prior: Prior = "auto",
    weight: float | None = None,
    total_mass: float | None = None,
    seed: int = 0,
) -> FeasibleCalibration:
    """Estimate parameters of an arm that belong to real bodies, so that a simulator takes them.

    Args:
        data: A data set, or its folder.
        model: As of `identify`.
        cutoff: Of the low-pass [Hz]; chosen from the data if None.
        prior: Reference bodies for what the data leave open: the robot file's ("file"), bodies of the
            size of the links ("neutral"), or the file's where they are no placeholders ("auto").
        weight: Weight of the distance to the reference; by cross-validation if None.
        total_mass: Mass of all moving links together [kg], where it is known.
        seed: Seed of poses and bootstrap.

    Returns:
        The feasible estimate beside the plain one, with its errors on every recording.

    Raises:
        DataSetError: If the folder holds no data set that can be used.
        OedError: If no bodies fulfil what is demanded.
    """
    prepared = prepare(data, model=model, cutoff=cutoff)
    demands = FeasibleSet.of(prepared.model).with_(total_mass=total_mass)
    inertials = file_inertials(prepared.model.robot, wanted=WANTED[prior])
    settings = FeasibleSettings(demands=demands, inertials=inertials, weight=weight, seed=seed)
    return estimate(prepared, settings)


def estimate(prepared: Prepared, settings: FeasibleSettings) -> FeasibleCalibration:
    """The same from a data set that is ready."""
    prepared.dataset.robot.require_newton_metres(prepared.dataset.name)
    plain = calibrate(
        prepared.dataset,
        prepared.model,
        prepared.settings,
        known=prepared.known,
        noise_of=prepared.noise_of,
        fixed_signs=prepared.fixed_signs,
    )
    parameters = counted(len(prepared.model.parameters), "parameter")
    say(f"estimating {parameters} of {counted(prepared.dataset.robot.n, 'joint')} feasibly")
    return calibrate_feasibly(plain, settings)


def export(result: FeasibleCalibration, out: Path, home: Path) -> list[Row]:
    """Write the robot files and parameters.yaml; one row a robot file, with its round trip.

    Args:
        result: To write.
        out: Folder to write to.
        home: Folder that the files are moved to when all are whole.

    Raises:
        ExportMismatch: If a file computes other torques than the estimate.
    """
    estimate = result.estimate
    calibrated = CalibratedRobot.of(estimate.model, estimate.parameters)
    motion = _some(result.plain.recordings["estimation"][0].motion)
    expected = calibrated.smooth_torque(motion)
    rows: list[Row] = []
    for name, write in (
        ("calibrated_robot.urdf", partial(write_urdf, home=home)),
        ("calibrated_robot.sdf", write_sdf),
        ("calibrated_robot.xml", write_mjcf),
    ):
        path = write(calibrated, out / name)
        row: dict[str, str | float | None] = {
            "file": name,
            "Drake": require_round_trip(calibrated, path, motion),
            "Pinocchio": None,
        }
        if path.suffix != ".sdf":  # which Pinocchio's wheels are built without
            found = torque_by_pinocchio(path, calibrated, motion)
            row["Pinocchio"] = float(np.abs(found - expected).max() / np.abs(expected).max())
        rows.append({**row, "not in the file": ", ".join(calibrated.left_out) or None})
    write_parameters(
        ParameterTable(
            estimate.model.parameters,
            estimate.parameters,
            result.bootstrap.interval(),
            estimate.from_data,
            estimate.at_bound,
        ),
        out / "parameters.yaml",
        robot=estimate.robot.name,
        joints=estimate.robot.joint_names,
        method=f"feasible least squares; intervals: {result.bootstrap.method}",
    )
    return rows


def run(config: Feasible) -> int:
    """Estimate, and leave model.json, estimate.json, the robot's files, figures and report.html."""
    speak(quiet=config.quiet)
    start = time.perf_counter()
    with FEASIBLE.in_folder(config.out, config.inputs) as results:
        config = imported(config, config.out)
        prepared = prepare_for(config)
        result = estimate(prepared, settings_of(config, prepared.model))
        checkup = check_calibration(result.plain)
        with results.replaced() as new:
            rows = export(result, new, results.folder)
            provenance = Provenance.collect(config, seed=config.seed)
            model = of_feasible(result, provenance, prepared.started)
            write_model(model, new / MODEL, home=results.folder)
            write_feasible(result, rows, new, provenance, checkup=checkup)
    print("\n" + text_table(link_rows(result)))
    print(text_table(validation_rows(result)))
    print(text_table(rows))
    say(
        f"mass matrix positive definite in {100 * result.positive_definite:.4g} % of "
        f"{result.settings.poses} poses, plain least squares "
        f"{100 * result.plain_positive_definite:.4g} %"
    )
    say(f"pulled to {result.inertials.reason}")
    if result.changes:
        say(text_table(change_rows(result)))
    say(result.estimate.solution.accuracy)
    say(solver_comparison(result))
    for note in doubts_of_data(checkup):
        say(f"note: {note}")
    for warning in result.warnings:
        print(f"warning: {warning}")
    print(f"open {config.out / 'report.html'} ({time.perf_counter() - start:.1f} s)")
    return 0


def settings_of(config: Feasible, model: TorqueModel) -> FeasibleSettings:
    """What a command line asks for."""
    demands = FeasibleSet.of(model).with_(
        total_mass=config.total_mass,
        regions=collision_regions(model.robot) if config.collision else None,
    )
    inertials = file_inertials(model.robot, wanted=WANTED[config.prior])
    if config.smoke:
        return FeasibleSettings(
            demands=demands,
            inertials=inertials,
            kind=config.kind,
            weight=config.weight,
            weights=(1e-5, 1e-3, 1e-1),
            folds=2,
            blocks=4,
            resamples=3,
            poses=500,
            seed=config.seed,
        )
    return FeasibleSettings(
        demands=demands,
        inertials=inertials,
        kind=config.kind,
        weight=config.weight,
        seed=config.seed,
    )


def _some(motion: Motion) -> Motion:
    return motion[np.linspace(0, len(motion) - 1, ROUND_TRIP_SAMPLES).astype(int)]
