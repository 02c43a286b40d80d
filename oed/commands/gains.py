"""`oed gains`: how many newton metres an ampere is, joint by joint, from known loads."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from oed.checkup.reversed_sign import check_signs
from oed.commands.configurations import Gains as Config
from oed.commands.from_data_set import Prepared, held_out_notes, prepare_at
from oed.commands.telling import say, speak
from oed.counted import counted
from oed.dynamics.friction_curve import with_friction_curve
from oed.errors import NoUsableResult
from oed.estimation.load.current_equations import CurrentEquations, KnownLoad
from oed.estimation.load.explained import check_explained
from oed.estimation.load.gains import estimate_gains
from oed.estimation.load.loaded_model import LoadedModel
from oed.estimation.load.same_arm import check_same_arm
from oed.estimation.stacking import process_all
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.preparation.settings import choose_settings
from oed.process_end import NO_USABLE_RESULT
from oed.report.gains_page import GainsReport, gain_rows, write_gains
from oed.report.provenance import Provenance
from oed.report.study_files import GAINS
from oed.report.table import text_table
from oed.robot.attached_frame import find_frame


def measure(config: Config) -> GainsReport:
    """Estimate gains as a command asks for it.

    Raises:
        OtherArm: If the data sets are not of one arm.
        NoUsableResult: If torques are no currents, have the opposite sign, or are not explained.
    """
    loaded = [prepare_at(folder, config) for folder in config.loaded]
    bare = None if config.bare is None else prepare_at(config.bare, config)
    every = [*([bare] if bare else []), *loaded]
    notes = held_out_notes(*every)
    for other in every[1:]:
        notes += check_same_arm(every[0].dataset, other.dataset)
    dataset = every[0].dataset
    _require_currents(dataset)
    # One band for all: what is common to them must be one and the same.
    cutoff = min(prepared.settings.cutoff for prepared in every)
    frame = find_frame(dataset.robot, config.frame)
    say(f"estimating the gains of {counted(dataset.robot.n, 'joint')}")
    first = _estimation(every[0], cutoff)
    model = LoadedModel.bare(with_friction_curve(every[0].model), frame).turning_as(first)
    equations = CurrentEquations.of(
        model,
        () if bare is None else _estimation(bare, cutoff),
        [_estimation(prepared, cutoff) for prepared in loaded],
        _loads(config),
    )
    gains = estimate_gains(equations, dataset.drive.current_to_torque)
    check_explained(gains.relative_rms, dataset.robot.joint_names)
    return GainsReport(gains, dataset, notes)


def _estimation(prepared: Prepared, cutoff: float) -> tuple[ProcessedRecording, ...]:
    settings = prepared.settings
    if settings.cutoff > cutoff:
        narrower = choose_settings(prepared.dataset.recordings, cutoff=cutoff)
        settings = narrower.with_velocity(settings.velocity, settings.velocity)
    recordings = process_all(prepared.dataset, settings)["estimation"]
    check_signs(prepared.dataset, prepared.model, recordings)
    return recordings


def _require_currents(dataset: DataSet) -> None:
    if dataset.torque != "current":
        raise NoUsableResult(
            f"{dataset.name}: its torques are {dataset.torque}, not from currents: there is no gain to "
            'find; where the columns are currents, say torque = "current" in dataset.toml'
        )


def _loads(config: Config) -> Sequence[KnownLoad]:
    """What is known of the load in each folder."""
    count = len(config.loaded)
    if not config.mass:
        return [KnownLoad()] * count
    masses = config.mass * count if len(config.mass) == 1 else config.mass
    if not config.com:
        return [KnownLoad(mass) for mass in masses]
    centres = np.array(config.com * count if len(config.com) == 3 else config.com).reshape(-1, 3)
    return [KnownLoad(mass, centre) for mass, centre in zip(masses, centres, strict=True)]


def run(config: Config) -> int:
    """Estimate, and leave gains.json and report.html; 3 if no joint's gain is told."""
    speak(quiet=config.quiet)
    start = time.perf_counter()
    inputs = [*config.loaded, *([config.bare] if config.bare else [])]
    with GAINS.in_folder(config.out, inputs) as results:
        report = measure(config)
        with results.replaced() as new:
            write_gains(report, new, Provenance.collect(config, seed=None))
    print("\n" + text_table(gain_rows(report)))
    for line in report.lines:
        print(line)
    print(f"open {config.out / 'report.html'} ({time.perf_counter() - start:.1f} s)")
    told = [gain for gain in report.gains.gains if gain.value is not None]
    return 0 if told else NO_USABLE_RESULT
