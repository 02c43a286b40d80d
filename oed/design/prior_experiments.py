"""What earlier experiments tell, read back from their design files."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass


def prior_information(
    files: Sequence[str | Path], problem: DesignProblem
) -> Float[ndarray, "base base"]:
    """What the experiments of earlier design files tell about a problem's base parameters.

    Args:
        files: `design.json` of Fourier motions of the same joints.
        problem: Its model and noise; the instants are those of each file.

    Raises:
        ValueError: If a file cannot be read as a design, or moves other joints.
    """
    return np.sum([_information_of(Path(file), problem) for file in files], axis=0)


def _information_of(file: Path, problem: DesignProblem) -> Float[ndarray, "base base"]:
    robot = problem.model.robot
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
        joints, name, count = record["joints"], record["class"], int(record["instants"])
        horizon = float(record["horizon"])
        given = {key: np.array(x, dtype=float) for key, x in record["coefficients"].items()}
    except OSError as error:
        raise ValueError(f"{file}: cannot be read: {error.strerror}") from error
    except json.JSONDecodeError as error:
        raise ValueError(f"{file}: not JSON: {error}") from error
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{file}: not a design file: {error!r}") from error
    if name != FourierClass.name:
        raise ValueError(f"{file}: a motion of class {name!r}, not {FourierClass.name!r}")
    if joints != list(robot.joint_names):
        raise ValueError(f"{file}: it moves {joints}, not {list(robot.joint_names)}")
    if not (0 < horizon < np.inf and count > 0):
        raise ValueError(f"{file}: {horizon=} and {count} instants: both must be positive")
    parts = [given.get(part, np.empty(0)) for part in ("offset", "sine", "cosine")]
    shapes = [part.shape for part in parts]
    harmonics = shapes[1][1] if parts[1].ndim == 2 else 0
    if shapes != [(robot.n,), (robot.n, harmonics), (robot.n, harmonics)] or not harmonics:
        raise ValueError(
            f"{file}: offset, sine and cosine have shapes {shapes}, "
            f"not those of a series of {robot.n} joints"
        )
    parts[0] = parts[0][:, None]
    z = np.concatenate(parts, axis=1).reshape(-1)
    if not np.isfinite(z).all():
        raise ValueError(f"{file}: a coefficient is not a finite number")
    series = FourierClass(horizon, problem.limits, harmonics)
    return problem.fast.information(series.motion(z, series.instants(count)))
