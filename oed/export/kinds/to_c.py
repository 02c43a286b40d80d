"""A model as C99 without dependencies."""

from __future__ import annotations

from oed.export.c_code import write_c
from oed.export.model import Model
from oed.export.predictor import Predictor
from oed.export.registry import Exported, Target


def write(model: Model, target: Target) -> Exported:
    """Write oed_model.c and oed_model.h."""
    predictor = Predictor.of(model, target.step)
    source, header = write_c(predictor, target.folder)
    use = f"cc -std=c99 -O2 -c {source.name}; what to call is in {header.name}"
    return Exported((source.name, header.name), use, predictor.left_out)
