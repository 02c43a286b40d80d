"""A model as CasADi functions, for optimal control and estimation."""

from __future__ import annotations

from oed.export.model import Model
from oed.export.predictor import Predictor
from oed.export.registry import Exported, Target


def write(model: Model, target: Target) -> Exported:
    """Write one file a function: torque, its memory, and its parts."""
    predictor = Predictor.of(model, target.step)
    files = []
    for name, function in predictor.functions.items():
        files.append(f"{name}.casadi")
        function.save(str(target.folder / files[-1]))
    use = 'casadi.Function.load("torque.casadi")(q, dq, ddq, memory) gives the torque and the next memory'
    return Exported(tuple(files), use, predictor.left_out)
