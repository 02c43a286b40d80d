"""Everything that may be added to a model, as whitened columns ready to be judged."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.terms.loads import white_load
from oed.diagnosis_new.noise.addition import gram_of
from oed.diagnosis_new.rows.model_columns import effect_columns
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.dynamics.effects import Effect
from oed.dynamics.effects.arguments import OtherTorque
from oed.dynamics.effects.catalogue import CATALOGUE, CatalogueEntry, Context, Shape, Target
from oed.dynamics.effects.payload import PayloadChange
from oed.dynamics.effects.smooth_term import FreeForm
from oed.experiment.preparation.prepared import Prepared

FREE_FORM = "free_form"


@dataclass(frozen=True)
class Trial:
    """One effect with its shape fixed, as columns on the whitened rows.

    Attributes:
        name: Of the catalogue, or "free_form".
        target: Joint, pair of joints, or None for the arm.
        values: Of the shapes.
        effect: As columns of a torque model; first order where the exact form is none.
        group: White columns for each joint that they act on.
        fixed: Whether its coefficient is one by construction.
        shapes: Number of nonlinear parameters; the terms of a formula are no such.
        contrast: Whether its columns are their differences between repetitions alone.
        decided: Whether its shapes are those that estimation and validation recordings want
            together.
    """

    name: str
    target: Target
    values: tuple[float, ...]
    effect: Effect
    group: Mapping[int, Float[ndarray, "rows columns"]]
    fixed: bool
    shapes: int
    contrast: bool = False
    decided: bool = False

    @cached_property
    def gram(self) -> Float[ndarray, "columns columns"]:
        """Products of its white columns with one another."""
        return gram_of(self.group)

    @property
    def key(self) -> tuple[str, object]:
        """What competes as one candidate: all shapes of one effect at one place."""
        if isinstance(self.effect, FreeForm):
            return (self.effect.label, self.target)
        return (self.name, self.target)

    @property
    def freedom(self) -> int:
        """Parameters that are estimated: columns unless their size is fixed, and shapes."""
        return (0 if self.fixed else len(self.effect.parameters)) + self.shapes

    @property
    def joint(self) -> int | None:
        """The joint that a reader would name; None for the whole arm."""
        if isinstance(self.target, tuple):
            return self.target[0]
        return self.target

    @property
    def places(self) -> tuple[int | None, ...]:
        """The joints that it acts between, mostly one; None alone for the whole arm."""
        return self.target if isinstance(self.target, tuple) else (self.target,)

    @property
    def between_repetitions(self) -> bool:
        """Whether it makes repetitions differ, so that their mean does not show it."""
        if isinstance(self.effect, FreeForm):
            return any(c.kind == "time" for c in self.effect.coordinates)
        return CATALOGUE[self.name].between_repetitions

    @property
    def is_free_form(self) -> bool:
        """Whether it claims no physics."""
        return self.name == FREE_FORM

    def may_follow(self, other: Trial) -> bool:
        """Whether it is a free-form term of a joint on which another acts, and may do its part."""
        return self.is_free_form and self.joint in other.group

    @property
    def is_share(self) -> bool:
        """Whether it is a share of another joint's torque, or of its square."""
        return isinstance(self.effect, FreeForm) and any(
            isinstance(c, OtherTorque) for c in self.effect.coordinates
        )


def white_group(
    effect: Effect, rows: Rows, *, contrast: bool = False
) -> dict[int, Float[ndarray, "rows columns"]]:
    """White columns of an effect, joint by joint.

    Args:
        effect: To evaluate.
        rows: Where.
        contrast: Whether to keep only what differs between repetitions of one phase.
    """
    if isinstance(effect, PayloadChange) and all(p.laps is None for p in rows.prepared):
        return white_load(effect, rows, contrast=contrast)
    fine = [_fine_columns(effect, p, contrast=contrast) for p in rows.prepared]
    acting = sorted({joint for blocks in fine for joint in blocks})
    return {
        joint: rows.whiten_fine(
            [
                blocks.get(joint, np.zeros((len(p.motion), len(effect.parameters))))
                for blocks, p in zip(fine, rows.prepared, strict=True)
            ],
            joint,
        )
        for joint in acting
    }


def _fine_columns(
    effect: Effect, prepared: Prepared, *, contrast: bool
) -> dict[int, Float[ndarray, "samples columns"]]:
    """Columns of an effect on the fine grid, for the joints that it acts on."""
    if contrast:
        # What differs between repetitions by chance moves the arm as well as the torque: only the
        # mean motion is free of it, so that nothing but time can make these columns differ.
        blocks = effect_columns(effect, prepared.mean_motion, 0.0)
        return {joint: _contrasted(block, prepared) for joint, block in blocks.items()}
    if prepared.laps is None or not effect.beyond_state:
        return effect_columns(effect, prepared.motion, 0.0)
    # The mean over repetitions of what differs between them is not what any of them shows.
    laps = effect_columns(effect, prepared.laps, 0.0)
    length = len(prepared.motion)
    return {
        joint: block.reshape(-1, length, block.shape[1]).mean(axis=0)
        for joint, block in laps.items()
    }


def _contrasted(
    block: Float[ndarray, "samples columns"], prepared: Prepared
) -> Float[ndarray, "samples columns"]:
    """Columns less their mean over the repetitions at the same phase; as they are without."""
    return block if prepared.period is None else block - prepared.phase_mean(block)


def catalogue_trial(
    entry: CatalogueEntry,
    context: Context,
    target: Target,
    values: tuple[float, ...],
    rows: Rows,
    *,
    contrast: bool = False,
) -> Trial:
    """One entry at one place with one shape."""

    def make() -> Trial:
        effect = entry.build(context, target, values)
        return Trial(
            name=entry.name,
            target=target,
            values=values,
            effect=effect,
            group=white_group(effect, rows, contrast=contrast),
            fixed=entry.unit_coefficient,
            shapes=sum(
                shape.scale != "formula" and not shape.is_idle(value)
                for shape, value in zip(entry.shapes, values, strict=True)
            ),
            contrast=contrast,
        )

    return rows.trials.get((entry, context), make, (target, values, contrast))


def moved(trial: Trial, rows: Rows, context: Context, *, contrast: bool = False) -> Trial:
    """The same addition on other rows or with another context."""
    if trial.is_free_form:
        group = white_group(trial.effect, rows, contrast=contrast)
        return dataclasses.replace(trial, group=group, contrast=contrast)
    entry = CATALOGUE[trial.name]
    return catalogue_trial(entry, context, trial.target, trial.values, rows, contrast=contrast)


def dense(trial: Trial, joints: int, rows: int) -> Float[ndarray, "joints rows columns"]:
    """White columns of an addition on all joints, zero where it does not act."""
    columns = next(iter(trial.group.values())).shape[1]
    whole = np.zeros((joints, rows, columns))
    for joint, block in trial.group.items():
        whole[joint] = block
    return whole


def grid_of(shapes: Sequence[Shape]) -> Iterator[tuple[float, ...]]:
    """All combinations of the first scan's shape values."""
    return product(*(shape.grid for shape in shapes))


def free_form_trials(
    terms: Sequence[FreeForm], rows: Rows, *, contrast: bool = False
) -> list[Trial]:
    """Free-form terms as trials."""
    blocks: dict[tuple[object, ...], list[Float[ndarray, "_ columns"]]] = {}
    trials = []
    for term in terms:
        key = (term.coordinates, term.direction)
        if key not in blocks:
            blocks[key] = [_free_form_block(term, p, contrast=contrast) for p in rows.prepared]
        group = {term.joint: rows.whiten(blocks[key], term.joint)}
        trials.append(Trial(FREE_FORM, term.joint, (), term, group, False, 0, contrast))
    return trials


def _free_form_block(
    term: FreeForm, prepared: Prepared, *, contrast: bool
) -> Float[ndarray, "_ columns"]:
    """A term in the analysis band, like the torque: noise of speeds, unfiltered, would fold in."""
    motion = prepared.mean_motion if contrast else prepared.motion
    fine = effect_columns(term, motion, 0.0)[term.joint]
    return prepared.band.apply(_contrasted(fine, prepared) if contrast else fine)
