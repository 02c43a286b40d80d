"""`oed payload`: what an arm carries, with intervals, from recordings with and without the load."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.checkup.reversed_sign import check_signs
from oed.commands.configurations import Payload as Config
from oed.commands.from_data_set import Prepared, held_out_notes, prepare_at
from oed.commands.telling import say, speak
from oed.dynamics.friction_curve import with_friction_curve
from oed.dynamics.torque_model import TorqueModel
from oed.errors import NoUsableResult
from oed.estimation.load.explained import check_explained
from oed.estimation.load.known_arm import FoundArm, KnownArm
from oed.estimation.load.loaded_model import LoadedModel
from oed.estimation.load.payload import estimate_payload, with_friction
from oed.estimation.load.same_arm import check_same_arm, check_same_robot
from oed.estimation.load.undetermined import open_quantities
from oed.estimation.stacking import process_all
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.preparation.settings import ProcessingSettings
from oed.export.load_files import write_load
from oed.export.model_file import load_model, model_file_at
from oed.report.payload_page import PayloadReport, write_payload
from oed.report.payload_rows import load_rows, residual_rows
from oed.report.provenance import Provenance
from oed.report.study_files import PAYLOAD
from oed.report.table import text_table
from oed.robot.attached_frame import AttachedFrame, find_frame


@dataclass(frozen=True)
class _Given:
    """What the load is estimated from.

    Attributes:
        loaded: The data set with the load.
        settings: How that is processed.
        recordings: Of it, processed.
        bare: Processed recordings of the bare arm; none where there are none.
        found: The model of the bare arm that was given.
        torque_model: Of the loaded data set's robot, where no model was given.
        frame: Where the load is held.
        notes: On the two data sets.
    """

    loaded: DataSet
    settings: ProcessingSettings
    recordings: tuple[ProcessedRecording, ...]
    bare: tuple[ProcessedRecording, ...]
    found: FoundArm | None
    torque_model: TorqueModel
    frame: AttachedFrame
    notes: tuple[str, ...]


def weigh(config: Config) -> PayloadReport:
    """Estimate a load as a command asks for it.

    Raises:
        OtherArm: If the two data sets, or the model, are not of one arm.
        NoUsableResult: If torques are in amperes or have the opposite sign, nothing tells the arm
            from its load, or both explain nothing of the torque.
    """
    given = _given(config)
    arm = _arm(given, has_load_friction=True)
    say(f"the arm is taken from {arm.words}")
    say(f"estimating what {given.frame.name} holds")
    payload = estimate_payload(arm, given.recordings)
    check_explained(payload.relative_rms, given.loaded.robot.joint_names)
    without = estimate_payload(_arm(given, has_load_friction=False), given.recordings)
    payload = with_friction(payload, without)
    return PayloadReport(
        payload=payload,
        open_quantities=open_quantities(payload),
        dataset=given.loaded,
        settings=given.settings,
        notes=(*given.notes, *_model_note(given, arm), *_gain_note(given.loaded)),
    )


def _given(config: Config) -> _Given:
    loaded = prepare_at(config.loaded, config)
    loaded.dataset.robot.require_newton_metres(loaded.dataset.name)
    frame = find_frame(loaded.dataset.robot, config.frame)
    bare, found, notes = None, None, held_out_notes(loaded)
    if config.bare is not None:
        bare = prepare_at(config.bare, config)
        bare.dataset.robot.require_newton_metres(bare.dataset.name)
        notes = (*check_same_arm(bare.dataset, loaded.dataset), *held_out_notes(bare, loaded))
    if config.model is not None:
        found = _found(config.model)
        both = f"{config.model.name} and {loaded.dataset.name}"
        notes += check_same_robot(found.torque_model.robot, loaded.dataset.robot, both)
    return _Given(
        loaded=loaded.dataset,
        settings=loaded.settings,
        recordings=_estimation(loaded),
        bare=() if bare is None else _estimation(bare),
        found=found,
        torque_model=_richer(loaded, bare),
        frame=frame,
        notes=notes,
    )


def _richer(loaded: Prepared, bare: Prepared | None) -> TorqueModel:
    """The model of the folder whose data determine more: a rotor that one shows, both have."""
    if bare is None or len(bare.model.effects) <= len(loaded.model.effects):
        return loaded.model
    return bare.model


def _estimation(prepared: Prepared) -> tuple[ProcessedRecording, ...]:
    recordings = process_all(prepared.dataset, prepared.settings)["estimation"]
    check_signs(prepared.dataset, prepared.model, recordings)
    return recordings


def _found(path: Path) -> FoundArm:
    model = load_model(model_file_at(path))
    if model.covariance is None:
        raise NoUsableResult(
            f"{path}: this model has no covariance, so that nothing can be said of the load's error; "
            "give the model.json of oed identify"
        )
    return FoundArm(path.name, model.torque_model, model.parameters, model.covariance)


def _arm(given: _Given, *, has_load_friction: bool) -> KnownArm:
    if given.found is not None:
        return KnownArm.from_model(
            given.frame, given.found, given.recordings, has_load_friction=has_load_friction
        )
    bare = LoadedModel.bare(
        with_friction_curve(given.torque_model), given.frame, has_load_friction=has_load_friction
    ).turning_as(given.bare or given.recordings)
    if given.bare:
        return KnownArm.from_recordings(bare, given.bare)
    return KnownArm.from_file(bare, given.recordings)


def _model_note(given: _Given, arm: KnownArm) -> Sequence[str]:
    """How well a given model foretells the bare arm, where there is a recording of it."""
    if given.found is None or not given.bare:
        return ()
    shares = arm.relative_rms(given.bare)
    names = given.loaded.robot.joint_names
    told = ", ".join(f"{name} {share:.1%}" for name, share in zip(names, shares, strict=True))
    return (f"the model leaves of the bare arm's torque: {told}",)


def _gain_note(dataset: DataSet) -> Sequence[str]:
    """What no interval of a load holds, where its torques are currents."""
    if dataset.torque != "current":
        return ()
    told = (
        "torques are currents times current_to_torque: the mass is off by as much as these are, 1 % "
        "for 1 %, and no interval here holds that; oed gains finds them from a weighed load"
    )
    return (told,)


def run(config: Config) -> int:
    """Estimate, and leave payload.json, the load for other programs, and report.html."""
    speak(quiet=config.quiet)
    start = time.perf_counter()
    inputs = [p for p in (config.loaded, config.bare, config.model) if p is not None]
    with PAYLOAD.in_folder(config.out, inputs) as results:
        report = weigh(config)
        with results.replaced() as new:
            files = write_load(report.payload.parameters, report.payload.frame.name, new)
            report = dataclasses.replace(report, files=files)
            write_payload(report, new, Provenance.collect(config, seed=None))
    print(f"\nload at {report.payload.frame.name}")
    print(text_table(load_rows(report.payload)))
    print(text_table(residual_rows(report)))
    for line in report.lines:
        print(line)
    print(f"open {config.out / 'report.html'} ({time.perf_counter() - start:.1f} s)")
    return 0
