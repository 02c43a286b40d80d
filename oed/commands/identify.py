"""`oed identify`: the dynamic parameters of an arm, and how far they can be trusted."""

from __future__ import annotations

import time
from pathlib import Path

from oed.checkup.checkup import check_calibration
from oed.commands.configurations import Identify, ModelName
from oed.commands.from_data_set import Prepared, prepare, prepare_for
from oed.commands.from_log import imported
from oed.commands.telling import say, speak
from oed.counted import counted
from oed.estimation.calibration import Calibration, calibrate, convergence, residual_spectrum
from oed.experiment.dataset import DataSet
from oed.export.found_models import of_calibration
from oed.export.model_file import NAME as MODEL
from oed.export.model_file import write_model
from oed.one_thread import on_one_thread
from oed.report.calibration_report import print_summary, write_calibration
from oed.report.provenance import Provenance
from oed.report.study_files import IDENTIFY


@on_one_thread
def identify(
    data: DataSet | str | Path,
    *,
    model: ModelName | None = None,
    cutoff: float | None = None,
    robust: bool = False,
) -> Calibration:
    """Estimate the base parameters of an arm, with intervals, and validate them.

    Args:
        data: A data set, or its folder.
        model: "standard" (rigid body, Coulomb and viscous friction), "offset" (a constant torque
            a joint besides) or "rotor" (a rotor inertia a joint besides); if None "rotor" where the
            data set declares gears and determines it, else "standard".
        cutoff: Of the low-pass [Hz]; chosen from the data if None.
        robust: Whether to use Huber's loss in place of least squares.

    Returns:
        The estimate, and its errors on every recording.

    Raises:
        DataSetError: If the folder holds no data set that can be used.
        OedError: If the data determine nothing.
    """
    return estimate(prepare(data, model=model, cutoff=cutoff), robust=robust)


def estimate(prepared: Prepared, *, robust: bool) -> Calibration:
    """The same from a data set that is ready."""
    say(f"estimating: {counted(prepared.dataset.robot.n, 'joint')}")
    return calibrate(
        prepared.dataset,
        prepared.model,
        prepared.settings,
        robust="huber" if robust else None,
        known=prepared.known,
        noise_of=prepared.noise_of,
        fixed_signs=prepared.fixed_signs,
        say=say,
    )


def run(config: Identify) -> int:
    """Estimate, and leave model.json, estimate.json, parameters.csv, figures and report.html."""
    speak(quiet=config.quiet)
    start = time.perf_counter()
    with IDENTIFY.in_folder(config.out, config.inputs) as results:
        config = imported(config, config.out)
        prepared = prepare_for(config)
        calibration = estimate(prepared, robust=config.robust)
        checkup = check_calibration(calibration)
        provenance = Provenance.collect(config, seed=None)
        with results.replaced() as new:
            model = of_calibration(calibration, provenance, prepared.started)
            write_model(model, new / MODEL, home=results.folder)
            write_calibration(
                calibration,
                convergence(calibration),
                residual_spectrum(calibration),
                new,
                provenance,
                checkup=checkup,
            )
    print_summary(calibration, checkup)
    print(f"open {config.out / 'report.html'} ({time.perf_counter() - start:.1f} s)")
    return 0
