"""The tables of one diagnosis: layouts, pools of trials and the held-out recordings."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.predict import prediction_errors, rms
from oed.diagnosis.tables.unseen import Unseen
from oed.diagnosis.tables.workbench import (
    Augmented,
    Layout,
    context_of,
    fit_with,
    lay_out,
)
from oed.diagnosis.terms.trials import Trial, catalogue_trial, free_form_trials, grid_of, moved
from oed.diagnosis_new.candidates.smooth_terms import terms_alone, terms_together, torques_of_others
from oed.diagnosis_new.noise.baseline import Baseline
from oed.diagnosis_new.rows.recent import Recent
from oed.dynamics.effects.catalogue import CATALOGUE, Context, Drives, Shape, Target
from oed.dynamics.effects.entries.history import MEASURED
from oed.dynamics.effects.payload import PickUp
from oed.dynamics.effects.smooth_term import FreeForm
from oed.experiment.preparation.mean_repetition import mean_of_repetitions
from oed.experiment.preparation.prepared import Prepared
from oed.parallel_map import side_by_side

NOTHING_KNOWN = Drives()
SAME = 0.999  # ratio of squares of two rounds, after which the reference torque has settled
MOST_STEPS = 8
RECENT_FITS = 16  # kept: what is asked of one addition is asked beside the same others


class Workshop:
    """The tables of one diagnosis: layouts, pools of trials and the held-out recordings.

    What it makes, it never changes. Two things of its own do change: `context`, which
    `update_context` takes from better fits, and `pickups`, the moments of a load in recordings
    that have one of their own.
    """

    def __init__(
        self,
        baseline: Baseline,
        estimation: tuple[Prepared, ...],
        validation: tuple[Prepared, ...],
        settings: DiagnosisSettings,
        *,
        drives: Drives = NOTHING_KNOWN,
        declared: Baseline | None = None,
        pickups: tuple[PickUp, ...] = (),
        later: tuple[Prepared, ...] = (),
    ) -> None:
        self.baseline, self.settings, self.drives = baseline, settings, drives
        # With the gravity that the data set declares; the tables may have been turned.
        self.declared = baseline if declared is None else declared
        self.full = lay_out(baseline, estimation, mean=False)
        repeated = any(mean_of_repetitions(p)[1] > 1 for p in estimation)
        self.mean = lay_out(baseline, estimation, mean=True) if repeated else self.full
        self.estimation, self.validation = estimation, validation
        self.pickups = pickups
        self.later = later or validation  # of which nothing but the clock is known to a search
        self._fits: Recent[Augmented] = Recent(RECENT_FITS)
        self.before = self._fitted((), self.mean, bend=False)
        self.context = self.context_with(self.before)
        self._validation_weights = baseline.noise_share(validation)

    def on(self, baseline: Baseline) -> Workshop:
        """The tables of the same data on another baseline."""
        same = baseline.model.robot.gravity is self.declared.model.robot.gravity
        return Workshop(
            baseline,
            self.estimation,
            self.validation,
            self.settings,
            drives=self.drives,
            declared=baseline if same else self.declared,
            pickups=self.pickups,
            later=self.later,
        )

    @property
    def is_turned(self) -> bool:
        """Whether gravity points elsewhere than declared."""
        return self.baseline is not self.declared

    @cached_property
    def upright(self) -> Workshop:
        """The tables under the gravity that was declared, with the noise of these."""
        return self.on(self.baseline.standing_as(self.declared))

    @property
    def most_effects(self) -> int:
        """How many effects may be added."""
        return self.settings.most_effects(self.context.n)

    def layout(self, trial: Trial) -> Layout:
        """The rows on which a trial is judged."""
        return self.layout_for([trial])

    def renewed(self, trial: Trial) -> Trial:
        """A trial on the rows of these tables, with what is known by now."""
        own = moved(trial, self.layout(trial).rows, self.context, contrast=trial.contrast)
        return dataclasses.replace(own, decided=trial.decided)

    def fit(
        self, chosen: Sequence[Trial], layout: Layout | None = None, *, bend: bool = True
    ) -> Augmented:
        """Fit with these additions, moved to the layout if they come from another.

        Args:
            chosen: The additions.
            layout: Rows; those that show all of these additions if None.
            bend: Whether shapes enter by their derivatives.
        """
        layout = self.layout_for(chosen) if layout is None else layout
        return self._fits.get(
            (layout, self.context, bend, *chosen), lambda: self._fitted(chosen, layout, bend=bend)
        )

    def _fitted(self, chosen: Sequence[Trial], layout: Layout, *, bend: bool) -> Augmented:
        context = self.context if chosen and bend else None
        own = [
            t
            if next(iter(t.group.values())).shape[0] == layout.rows.count and not t.contrast
            else dataclasses.replace(moved(t, layout.rows, self.context), decided=t.decided)
            for t in chosen
        ]
        return fit_with(self.baseline, layout, own, context)

    def update_context(self, found: Augmented) -> None:
        """Take the reference torque of load-dependent effects from a better fit."""
        self.context = self.context_with(found)

    def settle(
        self, chosen: Sequence[Trial], layout: Layout | None = None
    ) -> tuple[list[Trial], float]:
        """Additions on these tables, with what is known beside them, and the squares that they leave.

        They refer to the torque that is fitted beside them: what is fitted without a gain or an
        elastic gear is no torque to multiply or to bend.
        """
        own, left = list(chosen), np.inf
        for _ in range(MOST_STEPS):
            own = [self.renewed(trial) for trial in chosen]
            found = self.fit(own, layout, bend=False)
            if found.fit.squares > SAME * left:
                break
            left = found.fit.squares
            self.update_context(found)
        return own, left

    def context_with(self, found: Augmented) -> Context:
        """What the catalogue may know beside a fit."""
        rows = self.full.rows
        return context_of(found, rows, self.drives, self.later, self.pickups)

    def take_up(self, pickups: tuple[PickUp, ...]) -> None:
        """Have a load taken up at these moments."""
        self.pickups = pickups
        self.context = dataclasses.replace(self.context, pickups=pickups)

    @contextmanager
    def for_a_while(self) -> Iterator[None]:
        """What the tables learn within is forgotten."""
        known = self.context, self.pickups
        try:
            yield
        finally:
            self.context, self.pickups = known

    def layout_for(self, chosen: Sequence[Trial]) -> Layout:
        """Mean repetitions, or all of them if an addition makes them differ."""
        return self.full if any(t.between_repetitions for t in chosen) else self.mean

    def validation_rms(
        self, found: Augmented, *, as_it_is: bool = False
    ) -> Float[ndarray, " joints"] | None:
        """Held-out error of each joint [N m], of a fit `as_it_is` or as its parameters give way.

        None without validation recordings. With a late torque, as large as if the model made of
        the noise what it makes without.
        """
        if not self.validation:
            return None
        share = self.unseen.share_without_noise(found)
        if not as_it_is:
            lasting = found.fit.rows is not self.mean.rows
            found, _ = (self.unseen_full if lasting else self.unseen).given_way(found)
        errors = prediction_errors(found, self.validation, self.unseen_full.columns)
        valid = [e[p.valid] for e, p in zip(errors, self.validation, strict=True)]
        return rms(valid, self._validation_weights) * share

    def unseen_error(self, chosen: Sequence[Trial]) -> float:
        """Mean squared validation error over the joints, in squares of their noise floors.

        Zero without validation recordings.
        """
        errors = self.validation_rms(self.fit(chosen, bend=False))
        floor = self.baseline.floor.deviation
        return 0.0 if errors is None else float(np.mean((errors / floor) ** 2))

    @cached_property
    def unseen(self) -> Unseen:
        """The validation recordings, of their mean repetitions."""
        if all(p.period is None for p in self.validation):
            return self.unseen_full
        return Unseen.of(self.baseline, self.validation, mean=True)

    @cached_property
    def unseen_full(self) -> Unseen:
        """The same with every repetition."""
        return Unseen.of(self.baseline, self.validation, mean=False)

    def unseen_by(self, chosen: Sequence[Trial]) -> Unseen:
        """Mean repetitions, or all of them if an addition makes them differ."""
        return self.unseen if self.layout_for(chosen) is self.mean else self.unseen_full

    def foretold(
        self, others: Sequence[Trial], chosen: Sequence[Trial], *, as_it_is: bool = False
    ) -> list[Float[ndarray, " joints"] | None]:
        """Held-out errors without and with an addition; None without validation recordings.

        Of fits to what shows all of them: the mean of repetitions does not tell how they differ.
        """
        layout = self.layout_for(chosen)
        fits = (self.fit(own, layout, bend=False) for own in (others, chosen))
        return [self.validation_rms(fit, as_it_is=as_it_is) for fit in fits]

    @cached_property
    def physical(self) -> tuple[Trial, ...]:
        """Every candidate of the catalogue, everywhere, over the grid of its shapes."""
        names = (name for name in CATALOGUE if name in self.settings.candidates)
        places = [(name, t) for name in names for t in CATALOGUE[name].targets(self.context)]
        found = side_by_side(lambda place: list(self.candidates(*place)), places)
        return tuple(trial for own in found for trial in own)

    def candidates(self, name: str, target: Target) -> Iterator[Trial]:
        """The same of one effect at one place."""
        entry = CATALOGUE[name]
        contrast = entry.between_repetitions and self.full is not self.mean
        layout = self.full if entry.between_repetitions else self.mean
        shapes = entry.shapes_for(self.context, target)
        for values in (*grid_of(shapes), *entry.further(self.context)):
            yield catalogue_trial(
                entry,
                self.context,
                target,
                values,
                layout.rows,
                contrast=contrast and not _between_recordings(values, shapes),
            )

    def in_place_of(self, trial: Trial) -> list[Trial]:
        """Candidates that act on a joint on which an addition acts."""
        return [t for t in self.physical if not set(t.group).isdisjoint(trial.group)]

    @cached_property
    def smooth(self) -> tuple[Trial, ...]:
        """Free-form terms in one coordinate, or of another joint's torque."""
        steady = terms_alone(self.mean.rows.prepared, self.context.n)
        lasting = terms_alone(self.full.rows.prepared, self.context.n)
        others = torques_of_others(self.context.reference)
        return self._smooth_trials((*steady, *others), lasting)

    @cached_property
    def smooth_pairs(self) -> tuple[Trial, ...]:
        """Free-form terms in two coordinates."""
        joints = range(self.context.n)
        return self._smooth_trials(
            terms_together(self.mean.rows.prepared, self.context.n, joints),
            terms_together(self.full.rows.prepared, self.context.n, joints),
        )

    def _smooth_trials(
        self, steady: Sequence[FreeForm], lasting: Sequence[FreeForm]
    ) -> tuple[Trial, ...]:
        """Terms of the motion on the mean rows, terms of time on all of them."""
        still = [t for t in steady if "time" not in t.depends_on]
        repeated = self.full is not self.mean
        # On a motion that never comes back everything is a function of time: an alibi.
        timed = [t for t in lasting if "time" in t.depends_on] if repeated else []
        return tuple(
            free_form_trials(still, self.mean.rows)
            + free_form_trials(timed, self.full.rows, contrast=repeated)
        )


def _between_recordings(values: tuple[float, ...], shapes: Sequence[Shape]) -> bool:
    """Whether recordings show it more than their repetitions: what was in a pause, or warmth."""
    in_a_pause = (value in shape.also for value, shape in zip(values, shapes, strict=True))
    return MEASURED in values or any(in_a_pause)
