"""Which physically consistent parameters explain this arm's torque, and what does that cost?

    python -m studies.feasible --data DIR --out DIR [--joints A B …] [--model NAME] [--cutoff HZ]
        [--prior | --no-prior] [--kind entropic|quadratic] [--weight W] [--total-mass KG] [--collision]
        [--smoke] [--seed N]

Reads a data set, estimates standard parameters under physical constraints, compares them with
plain least squares, and leaves estimate.json, parameters.yaml, calibrated_robot.urdf, .sdf and
.xml (MJCF), figures and report.html. Each robot file is loaded again and its torques are compared.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.errors import OedError
from oed.estimation.calibration import calibrate
from oed.estimation.feasible.calibration import (
    FeasibleCalibration,
    FeasibleSettings,
    calibrate_feasibly,
)
from oed.estimation.feasible.collision_regions import collision_regions
from oed.estimation.feasible.feasible_set import FeasibleSet
from oed.estimation.feasible.reference import file_inertials
from oed.estimation.feasible.regularisation import RegularisationKind
from oed.export.calibrated_robot import CalibratedRobot
from oed.export.mjcf import write_mjcf
from oed.export.parameter_file import ParameterTable, write_parameters
from oed.export.round_trip import require_round_trip, torque_by_pinocchio
from oed.export.sdf import write_sdf
from oed.export.urdf import write_urdf
from oed.report.feasible_report import write_feasible
from oed.report.feasible_rows import change_rows, link_rows, solver_comparison, validation_rows
from oed.report.provenance import Provenance
from oed.report.study_files import FEASIBLE
from oed.report.table import Row, text_table
from studies.from_data_set import DataSetConfig, add_arguments, prepare, say
from studies.interrupt import leave
from studies.whole_numbers import from_zero

ROUND_TRIP_SAMPLES = 200


@dataclass(frozen=True)
class Config(DataSetConfig):
    """What to identify, and how; `smoke` takes few resamples and poses as well.

    Attributes:
        prior: Whether the inertials of the robot's file are a prior, else neutral bodies are;
            None takes them where they do not look like placeholders.
        kind: Of the pull to the reference.
        weight: Of that pull; by cross-validation if None.
        total_mass: Of all moving links [kg], where it is known.
        collision: Whether each link's mass must lie in a box around its collision geometry.
        seed: Of poses and bootstrap.
    """

    prior: bool | None = None
    kind: RegularisationKind = "entropic"
    weight: float | None = None
    total_mass: float | None = None
    collision: bool = False
    seed: int = 0


def run(config: Config) -> FeasibleCalibration:
    """Read, process, estimate plainly and feasibly, validate; says what it does."""
    dataset, model, settings = prepare(config)
    plain = calibrate(dataset, model, settings)
    say(f"estimating {len(model.parameters)} parameters of {dataset.robot.n} joints feasibly")
    return calibrate_feasibly(plain, _settings(config, model))


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


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 0 if all went well, 2 if the input cannot be used."""
    config = _parse(arguments)
    start = time.perf_counter()
    try:
        with FEASIBLE.in_folder(config.out, [config.data]) as results:
            result = run(config)
            with results.replaced() as new:
                rows = export(result, new, results.folder)
                write_feasible(result, rows, new, Provenance.collect(config, seed=config.seed))
    except (OedError, ValueError, OSError) as error:
        sys.stderr.write(f"studies.feasible: {error}\n")
        return 2
    say("\n" + text_table(link_rows(result)))
    say(text_table(validation_rows(result)))
    say(text_table(rows))
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
    for warning in result.warnings:
        say(f"warning: {warning}")
    say(f"wrote {config.out} in {time.perf_counter() - start:.1f} s")
    return 0


def _settings(config: Config, model: TorqueModel) -> FeasibleSettings:
    demands = FeasibleSet.of(model).with_(
        total_mass=config.total_mass,
        regions=collision_regions(model.robot) if config.collision else None,
    )
    inertials = file_inertials(model.robot, wanted=config.prior)
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


def _parse(arguments: Sequence[str] | None) -> Config:
    parser = argparse.ArgumentParser(prog="python -m studies.feasible", description=__doc__)
    add_arguments(parser)
    parser.add_argument(
        "--prior",
        action=argparse.BooleanOptionalAction,
        help="the inertials of the robot's file are a prior; unless told, where they are no placeholders",
    )
    parser.add_argument("--kind", choices=("entropic", "quadratic"), default=Config.kind)
    parser.add_argument("--weight", type=float, help="of the pull to the reference")
    parser.add_argument("--total-mass", type=float, help="of the moving links [kg]")
    parser.add_argument(
        "--collision", action="store_true", help="mass lies within the collision geometry"
    )
    parser.add_argument("--smoke", action="store_true", help="few samples, resamples and poses")
    parser.add_argument("--seed", type=from_zero, default=0)
    given = vars(parser.parse_args(arguments))
    return Config(**{**given, "joints": tuple(given["joints"])})


if __name__ == "__main__":
    leave(main, "studies.feasible")
