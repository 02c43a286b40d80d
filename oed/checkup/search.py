"""Test a data set for the one thing that may be wrong with it.

Refits tell what spoils the fit (`repair`), the robot file's own inertials what leaves it as it is
(`by_inertials`). Where no test shows a cause there is none to be named.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from oed.checkup.by_inertials import all_reversed, all_scaled, gravity_reversed
from oed.checkup.cause import USELESS, Cause
from oed.checkup.factor import untold
from oed.checkup.projection import Projection, project
from oed.checkup.repair import VERY_STRONG, Weighing, find_repair
from oed.checkup.trial import Outcome, Trials, with_rotors
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.recording import Role

NEAR_ZERO = 0.02  # of a joint's largest torque: the noise of a usual log; assumed
LEAST_TOUCHING = 2  # joints: one may be held that way by its weight


@dataclass(frozen=True)
class Search:
    """What the tests say of a data set.

    Attributes:
        cause: The one cause; None where no test shows one.
        projection: On the file's own inertials.
        as_logged: What the model leaves of the log as it is.
        untold: Joints whose torque could be ten times as large or as small, and the fit would not tell.
    """

    cause: Cause | None
    projection: Projection
    as_logged: Outcome
    untold: tuple[int, ...] = ()


def find_cause(
    dataset: DataSet,
    model: TorqueModel,
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
) -> Search:
    """Test a data set for what may be wrong with it.

    Args:
        dataset: As read.
        model: Of its robot, without measurement effects.
        recordings: By role, processed; a thinned rate will do.
    """
    projection = project(model, recordings)
    logs = tuple(r for group in recordings.values() for r in group)
    trials = Trials(with_rotors(model), logs)
    as_logged = trials.without_constants
    is_bad = bool((as_logged.relative > USELESS).any() or projection.contrary.any())
    cause, is_repaired = _magnitude(dataset) if is_bad else None, False
    if cause is None and projection.is_driven:
        cause = all_reversed(dataset, projection)
    if cause is None:
        cause, is_repaired = find_repair(trials, dataset, is_bad=is_bad)
    if cause is not None and cause.kind == "factor":
        # It is relative to the other joints: by the file's inertials all may be off, and these too.
        cause = all_scaled(dataset, projection) or cause
    # Of repairs that nothing tells apart none is named: the file's inertials, often made up, do not choose
    # among signs and scales. A gravity under which all of them agree is no accident.
    if cause is None and not is_repaired:
        cause = (
            _offset(trials) or all_reversed(dataset, projection) or all_scaled(dataset, projection)
        )
    if cause is None:
        cause = gravity_reversed(
            dataset, projection, lambda change: project(change.model(model), recordings)
        )
    unseen = untold(trials, VERY_STRONG) if cause is None else ()
    return Search(cause, projection, as_logged, unseen)


def _offset(trials: Trials) -> Cause | None:
    """Constant torques, which every fit may have, predict every joint that nothing did without."""
    fitted = trials.as_logged
    weighing = Weighing(trials.without_constants, (), (fitted,), trials.independent(fitted))
    without, beside = weighing.before.relative, fitted.relative
    bad = without > USELESS
    if not bad.any() or not weighing.repairs:
        return None
    if not weighing.mended[bad].all() or (beside[bad] > USELESS).any():
        return None
    names = trials.model.robot.joint_names
    shown = ", ".join(
        f"{names[j]} {without[j]:.2g} to {beside[j]:.2g}" for j in np.flatnonzero(bad)
    )
    return Cause(
        "offset",
        "the torques hold constant offsets",
        "estimate them: --model offset, or set the sensors to zero",
        f"they repair the fit: residual over torque of {shown}",
    )


def _magnitude(dataset: DataSet) -> Cause | None:
    """No torque is ever negative, though some come as near to zero as only a magnitude does."""
    tau = np.concatenate([recording.tau for recording in dataset.recordings])
    lowest, size = tau.min(axis=0), np.abs(tau).max(axis=0)
    # A weight that is held one way only keeps its torque away from zero.
    touches = lowest < NEAR_ZERO * size
    if (lowest < 0).any() or int(np.sum(touches & (size > 0))) < LEAST_TOUCHING:
        return None
    return Cause(
        "magnitude",
        "the torques are magnitudes: their signs are lost",
        "log the torques with their signs",
        f"no joint has a negative torque in any recording, though {int(touches.sum())} come near zero",
    )
