"""White rows of recordings that no fit has seen, and what a fit leaves of them.

Where a motion leaves parameters uncertain, a fit to it foretells another one badly whatever is
missing, and whether an addition mends that is chance. So base parameters give way there, at the
price of what they then explain less where they were fitted: as much in all as a fit to both would
leave more than one to the first (Plackett 1950, "Some theorems in least squares", Biometrika 37).
What a motion determines well hardly gives way, and what was added has to foretell as it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.fit.motion_noise import calmed
from oed.diagnosis.tables.predict import prediction_errors
from oed.diagnosis.tables.workbench import Augmented, lags_of, mean_rows
from oed.diagnosis_new.noise.baseline import Baseline
from oed.diagnosis_new.rows.model_columns import filtered_columns
from oed.diagnosis_new.rows.weighted_rows import Rows
from oed.experiment.preparation.prepared import Prepared

LEAST_SHARE = 0.1  # of the squares that is left of them without noise


@dataclass(frozen=True)
class Unseen:
    """Recordings that are predicted, never fitted.

    Attributes:
        rows: Their white rows; None without recordings.
        columns: Their filtered base columns.
        joints: Of the arm.
    """

    rows: Rows | None
    columns: list[Float[ndarray, "_ joints base"]]
    joints: int

    @classmethod
    def of(cls, baseline: Baseline, prepared: tuple[Prepared, ...], *, mean: bool) -> Unseen:
        """Lay out recordings.

        Args:
            baseline: Its noise whitens the rows, its columns predict.
            prepared: The recordings.
            mean: Whether repetitions are averaged. Encoder noise drives a prediction; a mean has
                less of it, so that a model is not preferred for being dull.
        """
        joints = baseline.model.robot.n
        if not prepared:
            return cls(None, [], joints)
        rows = mean_rows(baseline, prepared) if mean else baseline.rows(prepared)
        columns = [filtered_columns(baseline.model, p, baseline.columns) for p in rows.prepared]
        return cls(rows, columns, joints)

    @property
    def counted(self) -> Float[ndarray, " joints"]:
        """(n,) rows of each joint that count, at least one."""
        if self.rows is None:
            return np.ones(self.joints)
        return np.maximum(self.rows.counted, 1.0)

    @cached_property
    def white(self) -> Float[ndarray, "joints rows base"]:
        """White base columns."""
        if self.rows is None:
            return np.zeros((self.joints, 0, 0))
        return np.stack(
            [self.rows.whiten([c[:, j] for c in self.columns], j) for j in range(self.joints)]
        )

    def errors(self, found: Augmented) -> Float[ndarray, "joints rows"]:
        """(n, R) white errors of what a fit foretells."""
        if self.rows is None:
            return np.zeros((self.joints, 0))
        errors = prediction_errors(found, self.rows.prepared, self.columns)
        white = [self.rows.whiten([e[:, [j]] for e in errors], j)[:, 0] for j in range(self.joints)]
        return np.stack(white)

    def share_without_noise(self, found: Augmented) -> Float[ndarray, " joints"]:
        """(n,) ratio of root mean squares: with noise as the base model makes it, over as it is."""
        if self.rows is None or len(lags_of(found.chosen)) != 1:
            return np.ones(self.joints)
        left = self.left(found)
        other = sum(calmed(trial.effect, self.rows) for trial in found.chosen)
        return np.sqrt(np.maximum(left + other, LEAST_SHARE * left) / left)

    def left(self, found: Augmented) -> Float[ndarray, " joints"]:
        """(n,) squares that a fit leaves of each joint's white rows, as base parameters give way."""
        moved, price = self.given_way(found)
        return np.sum(self.errors(moved) ** 2, axis=1) + price

    def given_way(self, found: Augmented) -> tuple[Augmented, Float[ndarray, " joints"]]:
        """A fit with the base parameters that leave least in all, and what they cost.

        Returns:
            The fit, and (n,) by how much it leaves more of the rows that it was made on.
        """
        if self.rows is None:
            return found, np.zeros(self.joints)
        fit, count = found.fit, self.white.shape[2]
        # In the coordinates of its own span a fit has unit covariance; those of the base model
        # come first, and no addition has a share of them.
        base = ~fit.projection.inverse[count:].any(axis=0)
        inverse = fit.projection.inverse[:count, base]
        slopes = (self.white @ inverse).reshape(-1, inverse.shape[1])
        normal = slopes.T @ slopes + np.eye(slopes.shape[1])
        shift = np.linalg.solve(normal, slopes.T @ self.errors(found).ravel())
        parameters = fit.parameters.copy()
        parameters[:count] += inverse @ shift
        moved = replace(found, fit=replace(fit, parameters=parameters))
        return moved, np.sum((fit.projection.basis[:, :, base] @ shift) ** 2, axis=1)
