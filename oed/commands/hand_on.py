"""What a notebook hands on: a found model and a designed motion, as the commands write them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from oed.commands.configurations import Export
from oed.commands.design_output import Result
from oed.commands.diagnose import Outcome
from oed.commands.export import write_record
from oed.design.controller_files import files_for
from oed.design.export import SetPoints
from oed.errors import NoUsableResult
from oed.estimation.calibration import Calibration
from oed.estimation.feasible.calibration import FeasibleCalibration
from oed.export.found_models import of_calibration, of_diagnosis, of_feasible
from oed.export.model import Model
from oed.export.model_file import NAME as MODEL
from oed.export.model_file import load_model, model_file_at, write_model
from oed.export.registry import Exported, Target, find_exporter
from oed.report.provenance import Provenance
from oed.report.study_files import EXPORT, MOTION

Found = Model | Calibration | FeasibleCalibration | Outcome


def export_model(
    found: Found | str | Path,
    out: str | Path,
    *,
    to: Sequence[str] = (),
    rate: float = Export.rate,
) -> dict[str, Exported]:
    """Write a found model: model.json, and something that runs in each form that is asked for.

    Args:
        found: What `identify`, `identify_feasible`, `diagnose_data` or `load_model` returned, or a
            model.json or its folder.
        out: Folder to write to, new or of an earlier export.
        to: Forms, as of `oed export`: "numpy", "casadi", "c", "urdf", "sdf", "mjcf", "mujoco",
            "drake", "ros2", or one that was registered.
        rate: Rate at which a controller or a simulation asks for torque [Hz].

    Returns:
        What was written of each form, what it lacks, and how to use it.

    Raises:
        ValueError: If there is no such form, or the folder is another's.
        NoUsableResult: If a form cannot have this model, such as a robot file of base parameters.
    """
    config = Export(model=Path(MODEL), to=(*to, MODEL), out=Path(out), rate=rate)
    find = {name: find_exporter(name) for name in to}
    inputs = [found] if isinstance(found, (str, Path)) else []
    with EXPORT.in_folder(config.out, inputs) as results, results.replaced() as new:
        provenance = Provenance.collect(config, seed=None)
        model = _model_of(found, provenance)
        target = Target(new, results.folder, 1 / rate)
        done = {name: write(model, target) for name, write in find.items()}
        write_model(model, new / MODEL, home=results.folder)
        write_record(MODEL, model, done, provenance, new)
    return done


def export_motion(found: Result, out: str | Path, *, rate: float = 100.0) -> tuple[Path, ...]:
    """Write a designed motion for controllers: CSV, ROS 2 JointTrajectory, URScript, libfranka.

    URScript and libfranka are for arms of six and of seven revolute joints.

    Args:
        found: What `design_motion` returned.
        out: Folder to write to, new or of an earlier motion.
        rate: Set points a second [Hz].

    Returns:
        The files that were written, motion.csv first.

    Raises:
        NoUsableResult: If the motion does not keep a limit.
        ValueError: If the folder is another's.
    """
    design = found.design
    if not design.status.is_usable:
        raise NoUsableResult(f"this motion is not for a controller: {design.status}")
    robot = design.problem.model.robot
    points = SetPoints.sample(design.problem.trajectory, design.z, robot.joint_names, rate)
    files = files_for(robot)
    with MOTION.in_folder(Path(out)) as results, results.replaced() as new:
        for file in files:
            file.write(points, new / file.name)
    return tuple(Path(out) / file.name for file in files)


def _model_of(found: Found | str | Path, provenance: Provenance) -> Model:
    if isinstance(found, Calibration):
        return of_calibration(found, provenance)
    if isinstance(found, FeasibleCalibration):
        return of_feasible(found, provenance)
    if isinstance(found, Outcome):
        return of_diagnosis(found.found, found.dataset.name, provenance, found.started)
    return found if isinstance(found, Model) else load_model(model_file_at(Path(found)))
