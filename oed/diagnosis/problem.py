"""What is given: rows, base model, candidates. Nothing here changes."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.diagnosis.candidates.candidate import NamedCandidate, SmoothCandidate
from oed.diagnosis.rows.white_rows import WhiteRows
from oed.dynamics.effects.catalogue import CatalogueEntry, Context
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel


@dataclass(frozen=True, eq=False)
class Problem:
    """A base model, and rows on which others compete with it.

    Attributes:
        rows: Estimation and validation recordings.
        base: The base model.
        sharpest: The same with signs that turn as encoder noise alone has it.
        columns: (b,) of its columns that are estimated.
        base_precision: (b, b) of their prior: along what the estimation recordings do not carry to other
            motions they are zero, as in `oed identify`; elsewhere nothing is known of them.
        context: What is known of arm and data before any addition.
        floor: (n,) deviation of the noise [N m].
        is_floor_measured: Whether repetitions tell the noise. What a smooth fit leaves is no less than
            noise and may be far more: a model may leave less without having explained noise.
        names: What may be named.
        smooth: What claims no physics.
        most: Terms that may be added.
        nuisances: (n, R, k) white torque that noise of the motion makes, which may go together with
            noise of the torque: fitted beside every model, part of none.
        means: The same with the mean of every motion that was repeated, on which whatever is alike
            in all repetitions is looked for: as much of it in fewer rows; None where none was.
    """

    rows: WhiteRows
    base: TorqueModel
    sharpest: TorqueModel
    columns: Int[ndarray, " base"]
    base_precision: Float[ndarray, "base base"]
    context: Context
    floor: Float[ndarray, " joints"]
    is_floor_measured: bool
    names: Sequence[NamedCandidate]
    smooth: Sequence[SmoothCandidate]
    most: int
    nuisances: Float[ndarray, "joints rows nuisances"]
    means: Problem | None = None

    @property
    def sparse(self) -> Problem:
        """Where to look for what is alike in all repetitions."""
        return self.means or self

    @property
    def bare(self) -> Problem:
        """The same without nuisances."""
        means = None if self.means is None else self.means.bare
        return dataclasses.replace(self, nuisances=self.nuisances[:, :, :0], means=means)

    @property
    def candidates(self) -> tuple[NamedCandidate | SmoothCandidate, ...]:
        """All that may be added."""
        return (*self.names, *self.smooth)


def named_candidates(
    catalogue: Mapping[str, CatalogueEntry], names: Sequence[str], context: Context
) -> tuple[NamedCandidate, ...]:
    """Every effect at every place of an arm.

    Raises:
        ValueError: If the catalogue has no such name.
    """
    unknown = sorted(set(names) - set(catalogue))
    if unknown:
        raise ValueError(
            f"there is no effect {', '.join(unknown)}; there are {', '.join(sorted(catalogue))}"
        )
    return tuple(
        NamedCandidate(catalogue[name], target)
        for name in names
        for target in catalogue[name].targets(context)
    )


def full_parameters(
    model: TorqueModel, columns: Int[ndarray, " base"], values: Float[ndarray, " base"]
) -> Float[ndarray, " parameters"]:
    """Parameters of every column, regrouped ones at zero."""
    full = np.zeros(len(model.parameters))
    full[columns] = values
    return full


def visible_columns(problem: Problem, model: TorqueModel) -> Int[ndarray, " base"]:
    """Columns that any motion shows: under another gravity other combinations are."""
    if model.robot is problem.base.robot:
        return problem.columns
    return np.sort(base_parameters(dataclasses.replace(model, measurement=())).columns)
