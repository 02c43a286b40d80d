"""What are this arm's dynamic parameters, and how far can they be trusted?

    python -m studies.identify --data DIR --out DIR [--joints A B …] [--cutoff HZ]
                               [--model NAME] [--robust] [--smoke]

Reads a data set, estimates the base parameters of a torque model, validates them on the
recordings that were not used, and leaves estimate.json, parameters.csv, figures and report.html.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

from oed.checkup.checkup import check_calibration
from oed.errors import OedError
from oed.estimation.calibration import Calibration, calibrate, convergence, residual_spectrum
from oed.report.calibration_report import print_summary, write_calibration
from oed.report.provenance import Provenance
from oed.report.study_files import IDENTIFY
from studies.from_data_set import DataSetConfig, add_arguments, prepare, say
from studies.interrupt import leave


@dataclass(frozen=True)
class Config(DataSetConfig):
    """What to identify, and how.

    Attributes:
        robust: Whether to use a robust estimate (Huber) in place of least squares.
    """

    robust: bool = False


def run(config: Config) -> Calibration:
    """Read, process, estimate, validate; says what it does."""
    dataset, model, settings = prepare(config)
    say(f"estimating: {dataset.robot.n} joints, model {config.model!r}")
    return calibrate(dataset, model, settings, robust="huber" if config.robust else None)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 0 if all went well, 2 if the input cannot be used."""
    config = _parse(arguments)
    start = time.perf_counter()
    try:
        with IDENTIFY.in_folder(config.out, [config.data]) as results:
            calibration = run(config)
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
    except (OedError, ValueError, OSError) as error:
        sys.stderr.write(f"studies.identify: {error}\n")
        return 2
    print_summary(calibration, checkup)
    say(f"wrote {config.out} in {time.perf_counter() - start:.1f} s")
    return 0


def _parse(arguments: Sequence[str] | None) -> Config:
    parser = argparse.ArgumentParser(prog="python -m studies.identify", description=__doc__)
    add_arguments(parser)
    parser.add_argument("--robust", action="store_true", help="Huber loss")
    parser.add_argument("--smoke", action="store_true", help="as few samples as carry the band")
    given = vars(parser.parse_args(arguments))
    return Config(**{**given, "joints": tuple(given["joints"])})


if __name__ == "__main__":
    leave(main, "studies.identify")
