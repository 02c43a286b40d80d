"""Parameters with units and intervals as YAML, for programs that read no robot file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.effects import Parameter
from oed.report.json_file import write_atomically


@dataclass(frozen=True)
class ParameterTable:
    """What is known of each parameter.

    Attributes:
        parameters: (p,) names, units and joints.
        values: (p,) in the units.
        interval: (p, 2) [lower, upper]; nan where the data tell none, None where none was computed.
        from_data: (p,) share of each value that the data decide; the rest is the prior's.
        at_bound: (p,) whether a demand of physics presses on it: the interval then shows that
            demand, not how far the truth may be.
    """

    parameters: Sequence[Parameter]
    values: Float[ndarray, " p"]
    interval: Float[ndarray, "p 2"] | None
    from_data: Float[ndarray, " p"]
    at_bound: Bool[ndarray, " p"]


def write_parameters(
    table: ParameterTable,
    path: str | Path,
    *,
    robot: str,
    joints: Sequence[str],
    method: str,
    level: float = 0.95,
) -> Path:
    """Write parameters by joint, and those of the whole arm under "arm".

    Args:
        table: To write.
        path: Of the new file.
        robot: Name of the robot.
        joints: (n,) names.
        method: How values and intervals were found, in words.
        level: Confidence level of the intervals.

    Returns:
        The path.
    """
    path = Path(path)
    by_place: dict[str, dict[str, object]] = {name: {} for name in joints}
    for k, parameter in enumerate(table.parameters):
        entry: dict[str, object] = {"value": float(table.values[k]), "unit": parameter.unit}
        if table.interval is not None and np.isfinite(table.interval[k]).all():
            entry["interval"] = [float(bound) for bound in table.interval[k]]
        entry["from_data"] = round(float(table.from_data[k]), 4)
        entry["at_bound"] = bool(table.at_bound[k])
        place = "arm" if parameter.joint is None else joints[parameter.joint]
        by_place.setdefault(place, {})[parameter.name] = entry
    document = {
        "robot": robot,
        "method": method,
        "interval_level": level,
        "parameters": by_place,
    }
    text = yaml.safe_dump(document, sort_keys=False, allow_unicode=True, width=100)
    write_atomically(path, text)
    return path
