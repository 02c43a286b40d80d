"""Everything that a diagnosis may be told, in one place."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from oed.dynamics.effects.catalogue import CATALOGUE

EFFECTS_PER_JOINT = 2
LEAST_EFFECTS = 4
FEW_SURROGATES, FEW_REPLICATES = 39, 40  # of a diagnosis that is made smaller


@dataclass(frozen=True)
class DiagnosisSettings:
    """How carefully to look, and how sure to be before a name is given.

    Attributes:
        max_effects: Most effects that may be added; None for two a joint, at least four.
        level: Family-wise error of a search over all candidates.
        mop_up_floor: Least gain of a further effect as a share of the first one's.
        family_floor: The same where an earlier one has the candidate's family: it is more
            likely the same physics in another formula than a second effect.
        least_share: Least share of a joint's residual variance that a named effect removes.
            Below it, errors of smoothing and sampling look like physics.
        decisive: Difference in -2 log likelihood that separates two rivals.
        free_form_margin: By how much a free-form term's evidence must exceed that of physical ones.
        family_share: Share of a free-form term's gain that a named effect must reach.
        own_family_share: As `family_share`, for a free-form term of nothing but the named
            effect's own coordinate: the catalogue is then sure to hold the physics.
        foreign_share: As `family_share`, for a term that is linear in a signal with a coefficient
            that varies: no effect of the catalogue is, nor comes close to one in other words.
        mending_share: Gain of an addition over an earlier one's up to which it counts as mending
            that one's formula, if a free-form term of the same coordinate would do as well.
        floor_ratio: Error over noise floor up to which a model counts as complete if no term
            locates what is left.
        folds: Of the cross-validation within the estimation recordings.
        surrogates: Sign-flipped residuals that calibrate the search; up to ten times as many where a
            chance is near the level.
        refined: Candidates whose shape is refined after each scan.
        bootstrap: Replicates behind each interval of the proof.
        seed: Of surrogates and bootstrap.
        candidates: Names of the catalogue that may be given; fewer where it is known what
            cannot be there.
    """

    max_effects: int | None = None
    level: float = 0.01
    mop_up_floor: float = 0.01
    family_floor: float = 0.1
    least_share: float = 0.004
    decisive: float = 6.0
    free_form_margin: float = 10.0
    family_share: float = 0.85
    own_family_share: float = 0.6
    foreign_share: float = 0.95
    mending_share: float = 0.25
    floor_ratio: float = 1.3
    folds: int = 5
    surrogates: int = 99
    refined: int = 6
    bootstrap: int = 200
    seed: int = 0
    candidates: tuple[str, ...] = tuple(CATALOGUE)

    def __post_init__(self) -> None:
        unknown = [name for name in self.candidates if name not in CATALOGUE]
        if unknown:
            raise ValueError(f"no effects {unknown} in the catalogue; there are {list(CATALOGUE)}")

    def made_smaller(self) -> DiagnosisSettings:
        """The same with few draws: for a look, not for a result."""
        return dataclasses.replace(self, surrogates=FEW_SURROGATES, bootstrap=FEW_REPLICATES)

    def most_effects(self, joints: int) -> int:
        """How many effects may be added to an arm."""
        if self.max_effects is not None:
            return self.max_effects
        return max(LEAST_EFFECTS, EFFECTS_PER_JOINT * joints)

    def most_free_forms(self, joints: int) -> int:
        """How many free-form terms may be added: one a joint, at least four."""
        return min(max(LEAST_EFFECTS, joints), self.most_effects(joints))
