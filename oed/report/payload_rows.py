"""A load as rows: what a technician types, what the torque says, and the lines beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oed.estimation.load.payload import Payload
from oed.estimation.load.quantities import Quantity
from oed.estimation.load.undetermined import OpenQuantity
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.settings import ProcessingSettings
from oed.report.table import MISSING, Row

# By SI unit: factor, unit and digits after the point that a teach pendant takes.
PENDANT = {"kg": (1.0, "kg", 3), "m": (1e3, "mm", 1), "kg m^2": (1.0, "kg m^2", 5)}
LABELS = {"mass": "mass", "x": "centre x", "y": "centre y", "z": "centre z"}


@dataclass(frozen=True)
class PayloadReport:
    """A payload with what is told beside it.

    Attributes:
        payload: What was found.
        open_quantities: What was not.
        dataset: With the load.
        settings: How its signals were processed.
        notes: On the data.
        files: That the load was written to.
    """

    payload: Payload
    open_quantities: tuple[OpenQuantity, ...]
    dataset: DataSet
    settings: ProcessingSettings
    notes: tuple[str, ...] = ()
    files: tuple[str, ...] = ()

    @property
    def lines(self) -> tuple[str, ...]:
        """What is said beside the table, a sentence each."""
        return (
            f"the arm: {self.payload.arm.words}",
            *friction_lines(self.payload, self.dataset.robot.joint_names),
            *untold_lines(self.open_quantities),
            *(f"note: {note}" for note in self.notes),
        )


def untold_lines(quantities: Sequence[OpenQuantity]) -> tuple[str, ...]:
    """What was not found, a line for all that the same would tell."""
    by_remedy: dict[str, list[str]] = {}
    for each in quantities:
        by_remedy.setdefault(each.remedy, []).append(each.what)
    return tuple(f"not told: {', '.join(what)}; {remedy}" for remedy, what in by_remedy.items())


def load_rows(payload: Payload) -> list[Row]:
    """One row a number, in the units of a teach pendant, before and after."""
    return [_row(quantity) for quantity in payload.quantities]


def friction_lines(payload: Payload, joints: tuple[str, ...]) -> tuple[str, ...]:
    """What friction that grows with the load is, and what leaving it out would do to the mass."""
    friction = payload.friction
    if friction is None:
        return ()
    without = (
        f"without it the mass would be {friction.mass_without:.4g} kg "
        f"({interval_words(friction.interval_without, 'kg')}), {friction.mass_without - payload.mass:+.3g} kg off"
    )
    if not friction.found:
        return (f"friction that grows with the load: none is told from nothing; {without}",)
    told = ", ".join(
        f"{joints[j]} {friction.mu[j]:.1%} ({friction.interval[j, 0]:.1%} to "
        f"{friction.interval[j, 1]:.1%})"
        for j in friction.found
    )
    return (f"friction that grows with the load, a part of the model: {told} of it; {without}",)


def interval_words(interval: tuple[float, float] | None, unit: str) -> str:
    """An interval of a load's number, or that there is none."""
    if interval is None:
        return "the data do not bound it"
    low, high = interval
    return f"{low:.4g} to {high:.4g} {unit}"


def residual_rows(report: PayloadReport) -> list[Row]:
    """One row a joint: how much of the torque stays unexplained without the load and with it."""
    payload = report.payload
    torque = np.sqrt(np.mean(payload.equations.torque**2, axis=0))
    before = np.sqrt(np.mean(bare_residual(payload) ** 2, axis=0)) / torque
    names = report.dataset.robot.joint_names
    return [
        {
            "joint": name,
            "residual / torque, no load": float(without),
            "residual / torque, with it": float(share),
        }
        for name, without, share in zip(names, before, payload.relative_rms, strict=True)
    ]


def bare_residual(payload: Payload) -> np.ndarray:
    """(N, n) measured torque less that of the arm alone, as it was known before [N m]."""
    model, arm = payload.model, payload.arm
    at = payload.fit.parameters.copy()
    at[: len(model.base)] = arm.mean[: len(model.base)]
    at[model.load] = 0.0
    at[model.load_friction] = arm.mean[len(model.base) :]
    rows, torque = payload.equations.linearised(at)
    return torque - (rows @ at).reshape(torque.shape)


def _row(quantity: Quantity) -> Row:
    factor, unit, digits = PENDANT[quantity.unit]
    low, high = (
        (MISSING, MISSING)
        if quantity.interval is None
        else (f"{factor * bound:.{digits}f}" for bound in quantity.interval)
    )
    return {
        "": LABELS.get(quantity.name, f"{quantity.name} about the centre"),
        "before": f"{0.0:.{digits}f}",
        "after": f"{factor * quantity.value + 0.0:.{digits}f}",
        "lower95": low,
        "upper95": high,
        "unit": unit,
        "told by the data": quantity.is_determined,
    }
