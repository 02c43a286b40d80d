"""Which torque model every command starts from where none is named: one rule."""

from __future__ import annotations

import numpy as np

from oed.dynamics.effects import RotorInertia
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.models import build_model
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.identify import identify
from oed.estimation.stacking import process_all, stack
from oed.estimation.triangular import NotIdentifiable
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.settings import ProcessingSettings


def is_geared(dataset: DataSet) -> bool:
    """Whether the data set declares drives whose rotors turn faster than their joints."""
    ratio = dataset.drive.gear_ratio
    turns_faster = ratio is not None and bool(np.any(np.abs(ratio) > 1))
    return turns_faster or dataset.drive.rotor_inertia is not None


def choose_base_model(dataset: DataSet, settings: ProcessingSettings) -> tuple[str, str]:
    """Rotor inertias where drives have gears and the data determine one, else none.

    Args:
        dataset: With recordings for estimation.
        settings: Of the signal processing.

    Returns:
        The model's name and why it is that.
    """
    if not is_geared(dataset):
        return "standard", "the data set declares no gears"
    model = build_model("rotor", dataset.robot)
    told = [name for name in _determined(dataset, model, settings) if name in _rotors(model)]
    if not told:
        return "standard", "drives have gears, but the data determine no rotor's inertia"
    return "rotor", f"drives have gears, and the data determine {', '.join(told)}"


def _rotors(model: TorqueModel) -> set[str]:
    return {p.name for e in model.effects if isinstance(e, RotorInertia) for p in e.parameters}


def _determined(
    dataset: DataSet, model: TorqueModel, settings: ProcessingSettings
) -> tuple[str, ...]:
    """Names of the base parameters that the estimation recordings determine."""
    base = base_parameters(model)
    regressor, torque = stack(model, base, process_all(dataset, settings)["estimation"])
    try:
        estimate = identify(regressor, torque, base.names, base.units)
    except (NotIdentifiable, ValueError):
        return ()
    pairs = zip(estimate.names, estimate.determined, strict=True)
    return tuple(name for name, is_told in pairs if is_told)
