"""One data set laid out for diagnosis: rows, cached regressors, and fits with any additions."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.terms.secants import shape_derivatives
from oed.diagnosis.terms.trials import Trial, dense
from oed.diagnosis_new.noise.baseline import Baseline
from oed.diagnosis_new.noise.linear_fit import (
    LinearFit,
    Projection,
    fit_span,
    project,
    reversal_nuisances,
    whitened_regressor,
)
from oed.diagnosis_new.rows.recent import Recent
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects import MeasurementEffect
from oed.dynamics.effects.catalogue import CATALOGUE, Context, Drives
from oed.dynamics.effects.delay import TimeDelay
from oed.dynamics.effects.on_reference import OnReference
from oed.dynamics.effects.payload import PickUp
from oed.dynamics.effects.torque_change import TorqueChange
from oed.dynamics.effects.transmission import TransmissionChange
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.preparation.mean_repetition import mean_of_repetitions
from oed.experiment.preparation.prepared import Prepared

RECENT_SPANS = 16  # kept of a layout


@dataclass(frozen=True)
class Layout:
    """Rows of some recordings, and what every fit to them shares.

    Attributes:
        rows: The white rows.
        regressor: (n, R, b) white base columns.
        nuisances: (n, R, k) white nuisance columns.
        torque: (n, R) white torque.
    """

    rows: Rows
    regressor: Float[ndarray, "joints rows base"]
    nuisances: Float[ndarray, "joints rows nuisances"]
    torque: Float[ndarray, "joints rows"]

    @cached_property
    def span(self) -> Projection:
        """Of base columns and nuisances."""
        return project(np.concatenate([self.regressor, self.nuisances], axis=2))

    def span_with(self, chosen: Sequence[Trial]) -> Projection:
        """The span with additions on these rows one after another, those of fixed size left out.

        Made from that of all but the last, beside which much is asked.
        """
        if not chosen:
            return self.span
        *others, last = chosen
        if last.fixed:
            return self.span_with(others)
        return self._spans.get(
            tuple(chosen),
            lambda: self.span_with(others).extended(dense(last, *self.torque.shape)),
        )

    @cached_property
    def _spans(self) -> Recent[Projection]:
        return Recent(RECENT_SPANS)


@dataclass(frozen=True)
class Augmented:
    """The base model with some additions, fitted; shapes enter by their derivatives.

    Attributes:
        chosen: The additions.
        coefficients: Of each addition's columns (ones where fixed by construction).
        fit: Its projection holds base columns, additions and derivatives with respect to shapes.
        covariances: Of (coefficients, shapes on their axes) of each addition.
    """

    chosen: tuple[Trial, ...]
    coefficients: tuple[Float[ndarray, " _"], ...]
    fit: LinearFit
    covariances: tuple[Float[ndarray, "_ _"], ...]


def lay_out(baseline: Baseline, prepared: tuple[Prepared, ...], *, mean: bool) -> Layout:
    """Rows of recordings, of their mean repetitions if asked for."""
    return layout_of(baseline, mean_rows(baseline, prepared) if mean else baseline.rows(prepared))


def layout_of(baseline: Baseline, rows: Rows) -> Layout:
    """What every fit to some rows shares."""
    regressor = whitened_regressor(baseline.model, baseline.columns, rows)
    return Layout(rows, regressor, reversal_nuisances(rows), rows.torque())


def mean_rows(baseline: Baseline, prepared: tuple[Prepared, ...]) -> Rows:
    """White rows of the mean repetitions of recordings."""
    pairs = [mean_of_repetitions(p) for p in prepared]
    scales = tuple(float(1 / np.sqrt(count)) for _, count in pairs)
    return baseline.rows(tuple(p for p, _ in pairs), scales)


def context_of(
    found: Augmented,
    rows: Rows,
    drives: Drives,
    later: Sequence[Prepared],
    pickups: tuple[PickUp, ...] = (),
) -> Context:
    """What the catalogue may know when it proposes an effect.

    Args:
        found: The fit so far.
        rows: Where the effect may act.
        drives: What is known of them.
        later: Recordings on which it is judged.
        pickups: When a load is taken up in recordings that have a moment of their own.
    """
    # Only what depends on nothing but the state, or on what does, as a gear: a reference to a
    # reference would have no end.
    beside = tuple(
        (trial.effect.leaving, values)
        for trial, values in zip(found.chosen, found.coefficients, strict=True)
        if not trial.is_free_form
        and (CATALOGUE[trial.name].install is None or isinstance(trial.effect, TransmissionChange))
        and not isinstance(trial.effect, OnReference)
    )
    several = len(rows.prepared) > 1
    context = Context.of(
        found.fit.model,
        found.fit.full_parameters(),
        [p.motion for p in rows.prepared],
        drives,
        beside,
        later=[p.motion for p in later],
        ordered=not (several and all(p.laid and p.period is None for p in rows.prepared)),
    )
    return dataclasses.replace(context, pickups=pickups)


def fit_with(
    baseline: Baseline, layout: Layout, chosen: Sequence[Trial], context: Context | None
) -> Augmented:
    """Fit base model and additions together.

    Args:
        baseline: The base model.
        layout: Rows.
        chosen: Additions, their groups on these rows.
        context: Needed for derivatives with respect to shapes; without, they are left out.
    """
    joints, count, base = layout.regressor.shape
    target = layout.torque.copy()
    places = []
    start = base
    for trial in chosen:
        if trial.fixed:
            target -= dense(trial, joints, count).sum(axis=2)
        columns = 0 if trial.fixed else len(trial.effect.parameters)
        places.append(slice(start, start + columns))
        start += columns
    span = layout.span_with(chosen)
    linear = fit_layout(baseline, layout, span, target)
    coefficients = tuple(
        np.ones(len(t.effect.parameters)) if t.fixed else linear.parameters[p]
        for t, p in zip(chosen, places, strict=True)
    )
    if context is None or not any(t.shapes for t in chosen):
        return _augmented(tuple(chosen), coefficients, linear, places, [slice(0, 0)] * len(chosen))
    bends, blocks = [], []
    for trial, found in zip(chosen, coefficients, strict=True):
        derivatives = shape_derivatives(trial, found, layout.rows, context)
        bends.append(slice(start, start + derivatives.shape[2]))
        blocks.append(derivatives)
        start += derivatives.shape[2]
    bent = fit_layout(baseline, layout, span.extended(np.concatenate(blocks, axis=2)), target)
    return _augmented(tuple(chosen), coefficients, bent, places, bends)


def added_columns(
    found: Augmented, layout: Layout, context: Context
) -> Float[ndarray, "joints rows columns"]:
    """White columns of the additions of a fit, and of the derivatives by their shapes.

    Of a late torque only the derivatives: the other columns are as late as it makes them.
    """
    joints, rows, _ = layout.regressor.shape
    blocks = [np.zeros((joints, rows, 0))]
    late = lags_of(found.chosen)
    for trial, coefficients in zip(found.chosen, found.coefficients, strict=True):
        if late and not trial.fixed:
            alone = TorqueModel(context.model.robot, (trial.effect,), late)
            every = np.arange(len(alone.parameters))
            blocks.append(whitened_regressor(alone, every, layout.rows))
        elif _lag_of(trial) is None:
            blocks.append(dense(trial, joints, rows))
        blocks.append(shape_derivatives(trial, coefficients, layout.rows, context))
    return np.concatenate(blocks, axis=2)


def lags_of(chosen: Sequence[Trial]) -> tuple[MeasurementEffect, ...]:
    """What makes the torque of the whole arm late, among some additions."""
    return tuple(lag for lag in map(_lag_of, chosen) if lag is not None)


def early_and_late(chosen: Sequence[Trial]) -> list[Trial]:
    """Late torques of which one comes first: together they stand for a filter that no log has."""
    late = [t for t in chosen if _lag_of(t) is not None]
    return late if len(late) > 1 and any(map(comes_first, late)) else []


def comes_first(trial: Trial) -> bool:
    """Whether an addition is a torque that comes before what it does."""
    lag = _lag_of(trial)
    return isinstance(lag, TimeDelay) and lag.delay < 0


def is_pure_delay(trial: Trial) -> bool:
    """Whether an addition moves the torque of the whole arm in time, and does nothing else to it."""
    return isinstance(_lag_of(trial), TimeDelay)


def _lag_of(trial: Trial) -> MeasurementEffect | None:
    effect = trial.effect
    return effect.measurement if isinstance(effect, TorqueChange) else None


def _augmented(
    chosen: tuple[Trial, ...],
    coefficients: tuple[Float[ndarray, " _"], ...],
    fit: LinearFit,
    places: list[slice],
    bends: list[slice],
) -> Augmented:
    covariance = fit.covariance()
    covariances = []
    for place, bend in zip(places, bends, strict=True):
        index = np.concatenate(
            [np.arange(place.start, place.stop), np.arange(bend.start, bend.stop)]
        ).astype(int)
        covariances.append(covariance[np.ix_(index, index)])
    return Augmented(chosen, coefficients, fit, tuple(covariances))


def fit_layout(
    baseline: Baseline, layout: Layout, span: Projection, torque: Float[ndarray, "joints rows"]
) -> LinearFit:
    """Fit the base model, and what the span has besides, to a torque on these rows."""
    return fit_span(baseline.model, baseline.columns, layout.rows, span, torque)
