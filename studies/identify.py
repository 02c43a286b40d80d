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
from pathlib import Path

from oed.dynamics.models import MODELS, build_model
from oed.errors import OedError
from oed.estimation.calibration import (
    Calibration,
    calibrate,
    choose_velocity,
    convergence,
    residual_spectrum,
)
from oed.experiment.choose_settings import choose_settings
from oed.experiment.read_dataset import read_dataset
from oed.report.calibration_report import print_summary, write_calibration
from oed.report.output_folder import check_output_folder
from oed.report.provenance import Provenance

# Below this velocity the direction of a geared arm's motion is not known to the data; the
# baselines published with the measured sets use the same figure.
SIGN_WIDTH = 0.02  # [rad/s]


@dataclass(frozen=True)
class Config:
    """What to identify, and how.

    Attributes:
        data: Folder of the data set.
        out: Folder to leave results in.
        joints: Names of the joints to identify; all if empty.
        cutoff: Of the low-pass [Hz]; chosen from the data if None.
        model: Name of the torque model.
        sign_width: Velocity over which the Coulomb terms change sign [rad/s].
        robust: Whether to use a robust estimate (Huber) in place of least squares.
        smoke: Whether to keep only as few samples as carry the band.
    """

    data: Path
    out: Path
    joints: tuple[str, ...] = ()
    cutoff: float | None = None
    model: str = "rotor"
    sign_width: float = SIGN_WIDTH
    robust: bool = False
    smoke: bool = False


def run(config: Config) -> Calibration:
    """Read, process, estimate, validate; says what it does."""
    _say(f"reading {config.data}")
    dataset = read_dataset(config.data, joints=config.joints or None)
    for file, column in dataset.unused:
        _say(f"note: {file}: column {column!r} is not used")
    model = build_model(config.model, dataset.robot, sign_width=config.sign_width)
    settings = choose_settings(dataset)
    if config.cutoff is not None:
        settings = settings.with_cutoff(config.cutoff)
    settings = choose_velocity(dataset, model, settings)
    if config.smoke:
        settings = settings.thinned()
    for reason in settings.reasons:
        _say(f"  {reason}")
    _say(f"estimating: {dataset.robot.n} joints, model {config.model!r}")
    return calibrate(dataset, model, settings, robust="huber" if config.robust else None)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 0 if all went well, 2 if the input cannot be used."""
    config = _parse(arguments)
    start = time.perf_counter()
    try:
        check_output_folder(config.out)
        calibration = run(config)
        write_calibration(
            calibration,
            convergence(calibration),
            residual_spectrum(calibration),
            config.out,
            Provenance.collect(config, seed=None),
        )
    except (OedError, ValueError, OSError) as error:
        sys.stderr.write(f"studies.identify: {error}\n")
        return 2
    print_summary(calibration)
    _say(f"wrote {config.out} in {time.perf_counter() - start:.1f} s")
    return 0


def _parse(arguments: Sequence[str] | None) -> Config:
    parser = argparse.ArgumentParser(prog="python -m studies.identify", description=__doc__)
    parser.add_argument("--data", type=Path, required=True, help="folder of the data set")
    parser.add_argument("--out", type=Path, required=True, help="folder for the results")
    parser.add_argument("--joints", nargs="+", default=(), help="identify only these joints")
    parser.add_argument("--cutoff", type=float, help="low-pass cut-off [Hz]")
    parser.add_argument("--model", choices=sorted(MODELS), default=Config.model)
    parser.add_argument("--sign-width", type=float, default=SIGN_WIDTH, help="[rad/s]")
    parser.add_argument("--robust", action="store_true", help="Huber loss")
    parser.add_argument("--smoke", action="store_true", help="as few samples as carry the band")
    given = vars(parser.parse_args(arguments))
    return Config(**{**given, "joints": tuple(given["joints"])})


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
