"""The design file `design.json`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.criteria import condition, log10_det
from oed.design.design import Design
from oed.design.limits import KINEMATIC
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass

FORMAT = 1


def design_record(
    design: Design,
    *,
    versions: dict[str, str],
    d_efficiency: dict[str, object] | None = None,
    notes: tuple[str, ...] = (),
) -> dict[str, object]:
    """What `design.json` holds; infinite limits and undefined values are null.

    Args:
        design: The design.
        versions: Of the packages that made it.
        d_efficiency: {"value", "kind": "certified" or "estimated"}, where it was computed.
        notes: What was assumed, such as limits that the robot's file does not state.
    """
    problem, certificate = design.problem, design.certificate
    certified = certificate.certified_max
    return {
        "format": FORMAT,
        "robot": problem.model.robot.name,
        "joints": list(problem.model.robot.joint_names),
        "class": problem.trajectory.name,
        "coefficients": {name: value.tolist() for name, value in design.coefficients.items()},
        "horizon": design.horizon,
        "instants": len(problem.instants),
        "rows": problem.rows,
        "base_parameters": list(problem.base.names),
        "criterion": problem.criterion,
        "J_k": _number(design.J_k),
        "J_k_continuous": _number(design.J_k_continuous),
        "J_k_scaled": _number(design.J_k_scaled),
        "J_d_log10": _number(design.J_d),
        "J_d_log10_continuous": _number(design.J_d_continuous),
        "with_prior": _with_prior(design),
        "d_efficiency": d_efficiency,
        "certified_max": {**certified, "torque": certified.get("torque")},
        "certified_range": {
            kind: getattr(certificate, kind).tolist()
            for kind in (*KINEMATIC, "torque")
            if getattr(certificate, kind) is not None
        },
        "certified_violation": certificate.violation,
        "limits": {kind: _bounds(getattr(problem.limits, kind)) for kind in (*KINEMATIC, "torque")},
        "optimiser": design.optimiser,
        "seed": design.seed,
        "cpu_s": design.cpu_s,
        "evaluations": design.evaluations,
        "status": design.status,
        "notes": list(notes),
        "versions": versions,
    }


def _with_prior(design: Design) -> dict[str, float | None] | None:
    """J_k and J_d of this experiment and the earlier ones together; None if there were none."""
    if design.problem.prior is None:
        return None
    total = design.problem.information(design.z, scaled=False)
    return {"J_k": _number(condition(total)), "J_d_log10": _number(log10_det(total))}


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
        raise ValueError(f"--prior {file}: cannot be read: {error.strerror}") from error
    except json.JSONDecodeError as error:
        raise ValueError(f"--prior {file}: not JSON: {error}") from error
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise ValueError(f"--prior {file}: not a design file: {error!r}") from error
    if name != FourierClass.name:
        raise ValueError(f"--prior {file}: a motion of class {name!r}, not {FourierClass.name!r}")
    if joints != list(robot.joint_names):
        raise ValueError(f"--prior {file}: it moves {joints}, not {list(robot.joint_names)}")
    if not (0 < horizon < np.inf and count > 0):
        raise ValueError(f"--prior {file}: {horizon=} and {count} instants: both must be positive")
    parts = [given.get(part, np.empty(0)) for part in ("offset", "sine", "cosine")]
    shapes = [part.shape for part in parts]
    harmonics = shapes[1][1] if parts[1].ndim == 2 else 0
    if shapes != [(robot.n,), (robot.n, harmonics), (robot.n, harmonics)] or not harmonics:
        raise ValueError(
            f"--prior {file}: offset, sine and cosine have shapes {shapes}, "
            f"not those of a series of {robot.n} joints"
        )
    parts[0] = parts[0][:, None]
    z = np.concatenate(parts, axis=1).reshape(-1)
    if not np.isfinite(z).all():
        raise ValueError(f"--prior {file}: a coefficient is not a finite number")
    series = FourierClass(horizon, problem.limits, harmonics)
    return problem.fast.information(series.motion(z, series.instants(count)))


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _bounds(bounds: ndarray) -> list[list[float | None]]:
    return [[_number(lower), _number(upper)] for lower, upper in bounds]
