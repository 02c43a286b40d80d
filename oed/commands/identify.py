"""`oed identify`: the dynamic parameters of an arm, and how far they can be trusted."""

from __future__ import annotations

import time

from oed.checkup.checkup import check_calibration
from oed.commands.configurations import Identify
from oed.commands.from_data_set import prepare
from oed.commands.telling import say, speak
from oed.estimation.calibration import Calibration, calibrate, convergence, residual_spectrum
from oed.report.calibration_report import print_summary, write_calibration
from oed.report.provenance import Provenance
from oed.report.study_files import IDENTIFY


def estimate(config: Identify) -> Calibration:
    """Read, process, estimate, validate; says what it does."""
    dataset, model, settings = prepare(config)
    say(f"estimating: {dataset.robot.n} joints, model {config.model!r}")
    return calibrate(dataset, model, settings, robust="huber" if config.robust else None)


def run(config: Identify) -> int:
    """Estimate, and leave estimate.json, parameters.csv, figures and report.html."""
    speak(quiet=config.quiet)
    start = time.perf_counter()
    with IDENTIFY.in_folder(config.out, [config.data]) as results:
        calibration = estimate(config)
        checkup = check_calibration(calibration)
        with results.replaced() as new:
            write_calibration(
                calibration,
                convergence(calibration),
                residual_spectrum(calibration),
                new,
                Provenance.collect(config, seed=None),
                checkup=checkup,
            )
    print_summary(calibration, checkup)
    print(f"open {config.out / 'report.html'} ({time.perf_counter() - start:.1f} s)")
    return 0
