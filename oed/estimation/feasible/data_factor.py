"""Weighted torque equations of any number of samples as one small triangle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.torque_model import TorqueModel
from oed.estimation.noise import whiten
from oed.estimation.triangular import augment, triangularise
from oed.experiment.preparation.processed import ProcessedRecording

# Of a joint's mean squared torque: what seven digits of a log leave undecided.
ROUNDING = 1e-14
SMALLEST = 1e-30  # [N^2 m^2] for a joint whose torque is zero throughout


@dataclass(frozen=True)
class DataFactor:
    """[R z; 0 rho] of the weighted rows [H y]: |H pi - y|^2 = |R pi - z|^2 + rho^2.

    Attributes:
        triangle: (p + 1, p + 1) upper triangular.
        rows: Torque equations that went in.
    """

    triangle: Float[ndarray, "width width"]
    rows: int

    @classmethod
    def of(
        cls,
        regressor: Float[ndarray, "rows p"],
        torque: Float[ndarray, "samples joints"],
        variances: Float[ndarray, " joints"],
    ) -> DataFactor:
        """Factor of stacked rows, sample-major, weighted by the joints' torque variances."""
        joints = torque.shape[1]
        rows = augment(
            whiten(regressor, variances, joints), whiten(torque.reshape(-1), variances, joints)
        )
        return cls(triangularise(rows), len(rows))

    @classmethod
    def join(cls, parts: Sequence[DataFactor]) -> DataFactor:
        """The factor of all rows of several; a part may occur more than once.

        Raises:
            ValueError: If there is none.
        """
        if not parts:
            raise ValueError("no data to join")
        stacked = np.vstack([part.triangle for part in parts])
        return cls(triangularise(stacked), sum(part.rows for part in parts))

    @property
    def factor(self) -> Float[ndarray, "p p"]:
        """R."""
        return self.triangle[:-1, :-1]

    @property
    def target(self) -> Float[ndarray, " p"]:
        """The right-hand side z."""
        return self.triangle[:-1, -1]

    @property
    def remainder(self) -> float:
        """The residual norm rho that no parameter changes."""
        return float(self.triangle[-1, -1])

    def misfit(self, parameters: Float[ndarray, " p"]) -> float:
        """Mean squared weighted residual."""
        return float(np.sum((self.triangle @ np.append(-parameters, 1.0)) ** 2) / self.rows)


@dataclass(frozen=True)
class JointFactors:
    """Torque equations of each joint by themselves, so that their weights can still change.

    Attributes:
        joints: (n) a factor of each joint's rows, unweighted [N m].
    """

    joints: tuple[DataFactor, ...]

    @classmethod
    def of(
        cls, columns: Float[ndarray, "samples joints p"], torque: Float[ndarray, "samples joints"]
    ) -> JointFactors:
        """Factors of a model's columns and the measured torque."""
        one = np.ones(1)
        return cls(
            tuple(
                DataFactor.of(columns[:, j], torque[:, j : j + 1], one)
                for j in range(torque.shape[1])
            )
        )

    @classmethod
    def join(cls, parts: Sequence[JointFactors]) -> JointFactors:
        """The factors of all rows of several.

        Raises:
            ValueError: If there is none.
        """
        if not parts:
            raise ValueError("no data to join")
        by_joint = zip(*(part.joints for part in parts), strict=True)
        return cls(tuple(DataFactor.join(joint) for joint in by_joint))

    def weighted(self, variances: Float[ndarray, " joints"]) -> DataFactor:
        """One factor of all joints, weighted by torque variances [N^2 m^2]."""
        stacked = np.vstack(
            [
                joint.triangle / np.sqrt(variance)
                for joint, variance in zip(self.joints, variances, strict=True)
            ]
        )
        return DataFactor(triangularise(stacked), sum(joint.rows for joint in self.joints))

    def variances(self, parameters: Float[ndarray, " p"]) -> Float[ndarray, " joints"]:
        """Mean squared residual of each joint [N^2 m^2], no less than rounding of its torque."""
        found = []
        for joint in self.joints:
            torque = float(np.sum(joint.triangle[:, -1] ** 2) / joint.rows)
            found.append(max(joint.misfit(parameters), ROUNDING * torque, SMALLEST))
        return np.array(found)


def block_factors(
    model: TorqueModel, recordings: Sequence[ProcessedRecording], *, blocks: int
) -> tuple[JointFactors, ...]:
    """Factors of about `blocks` pieces of equal length, none across two recordings.

    Where a recording says what it repeats, its pieces are the repetitions.

    Args:
        model: Whose columns the rows have.
        recordings: At least one.
        blocks: Least number of pieces; each recording is at least one.
    """
    total = sum(len(recording) for recording in recordings)
    factors: list[JointFactors] = []
    for recording in recordings:
        block_of = _block_of_rows(recording, max(1, int(np.ceil(blocks * len(recording) / total))))
        parts: dict[int, JointFactors] = {}
        # The whole recording: an effect with a memory must not start anew in each block.
        for place, columns in recording.pieces(model.columns, remembers=model.remembers):
            root, tau = np.sqrt(recording.certainty[place]), recording.tau[place]
            for block in np.unique(block_of[place]).tolist():
                own = block_of[place] == block
                seen = [parts[block]] if block in parts else []
                part = JointFactors.of(columns[own] * root[own, :, None], tau[own] * root[own])
                parts[block] = JointFactors.join([*seen, part])
        factors += [parts[block] for block in sorted(parts)]
    return tuple(factors)


def _block_of_rows(recording: ProcessedRecording, share: int) -> Int[ndarray, " samples"]:
    """(N,) which block each row belongs to: its repetition, or one of `share` equal parts."""
    if recording.repetition is not None and len(np.unique(recording.repetition)) > 1:
        return recording.repetition
    parts = np.array_split(np.arange(len(recording)), share)
    return np.repeat(np.arange(len(parts)), [len(part) for part in parts])
