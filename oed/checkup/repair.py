"""The one cause that repairs the fit: all that is suspected is weighed here, by one criterion.

Every suspicion is a change of the log, under which the model is fitted anew to all recordings. What the
model lacks stays in the residual whatever is changed, and lasts longer than noise: rows are counted by
how long the residual of the better fit is correlated. A change repairs a fit if

- its likelihood is very strong evidence against the log before it: 2 log of the ratio beyond 10 (Kass
  and Raftery 1995, Bayes factors, J. Am. Stat. Assoc. 90, 773-795), and beyond what the likeliest of so
  many suspicions needs, each as probable as any other before the data: 2 log of their number;
- of some joint it explains most of what was left, and with it most of the torque is explained.

The likeliest suspicion is the cause if it repairs the fit, if the same evidence tells it from every
other one, and if none repairs what it leaves: then there are two faults, and which is not guessed. The
sign of a joint's torque and that of its position may do the same: then both are said. A torque in
another unit is no cause where ten times or a tenth of it would fit as well.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.checkup.cause import Cause
from oed.checkup.change import Change
from oed.checkup.factor import is_size_told, likeliest_factors
from oed.checkup.projection import Projection, project
from oed.checkup.suspicion import Suspicion, signs, suspicions
from oed.checkup.trial import Outcome, Trials
from oed.estimation.dissipation import LEAST_SHARE
from oed.experiment.dataset import DataSet

VERY_STRONG = 10.0  # 2 log of a likelihood ratio; Kass and Raftery 1995, section 3.2
MOST = 0.5  # of a mean square: more than half


@dataclass(frozen=True)
class Weighing:
    """Suspicions beside the log as it is, all weighed by what the likeliest of them leaves.

    Attributes:
        before: Without any of them.
        tried: Each, the likeliest first; none where what every fit may have is weighed.
        after: Of each, or of that.
        counts: (n,) independent samples of each torque.
    """

    before: Outcome
    tried: tuple[Suspicion, ...]
    after: tuple[Outcome, ...]
    counts: Float[ndarray, " joints"]

    def over(self, other: Outcome) -> float:
        """2 log likelihood ratio of the likeliest to another fit."""
        return other.deviance(self.counts) - self.after[0].deviance(self.counts)

    @property
    def mended(self) -> Bool[ndarray, " joints"]:
        """(n,) whether of a joint most is explained of what was left, and most of its torque."""
        before, after = self.before.relative, self.after[0].relative
        return after**2 < MOST * np.minimum(before**2, 1.0)

    @property
    def repairs(self) -> bool:
        """Whether the likeliest repairs the fit."""
        bar = VERY_STRONG + 2 * np.log(len(self.after))
        return bool(self.over(self.before) > bar and self.mended.any())


def weigh(trials: Trials, before: Outcome, suspected: Sequence[Suspicion]) -> Weighing:
    """Try each suspicion on the log that a change leaves.

    Args:
        trials: Of the log.
        before: With that change.
        suspected: Each a further change.
    """
    changes = [before.change.then(s.change) for s in suspected]
    equations = trials.equations([before.change, *changes])
    laid_out = list(zip(equations, [before.change, *changes], strict=True))
    alike = np.ones(len(before.residual))
    likeliest = min((e.fit(c) for e, c in laid_out[1:]), key=lambda o: o.deviance(alike))
    counts = trials.independent(likeliest)
    logged, *after = (e.fit(c, counts) for e, c in laid_out)
    ranked = sorted(zip(suspected, after, strict=True), key=lambda t: t[1].deviance(counts))
    tried, outcomes = tuple(s for s, _ in ranked), tuple(o for _, o in ranked)
    return Weighing(logged, tried, outcomes, counts)


def find_repair(trials: Trials, dataset: DataSet, *, is_bad: bool) -> tuple[Cause | None, bool]:
    """The cause that alone repairs the fit, and whether any suspicion does.

    Args:
        trials: Of the data set's recordings.
        dataset: As read.
        is_bad: Whether positions are suspected even if nothing else repairs the fit: they cost most.
    """
    every = tuple(suspicions(dataset))
    factors = likeliest_factors(trials, dataset, trials.as_logged.change)
    of_torque = tuple(s for s in every if not s.change.moves)
    found = weigh(trials, trials.as_logged, (*of_torque, *factors))
    if is_bad or found.repairs:
        several = _several_signs(trials, dataset)
        found = weigh(trials, trials.as_logged, (*every, *several, *factors))
    if not found.repairs:
        return None, False
    if not is_size_told(trials, found.after[0].change, VERY_STRONG):
        return None, True
    alike, rivals = _parted(found)
    lead = min(found.over(other) for other in rivals)
    beside = every
    if found.tried[0].kind == "factor":
        beside += tuple(likeliest_factors(trials, dataset, found.after[0].change))
    if lead <= VERY_STRONG or weigh(trials, found.after[0], beside).repairs:
        return None, True
    said = _said(trials, dataset, found, alike)
    if not said:
        return None, True
    text, remedy = (
        ", or ".join(words) for words in zip(*((s.text, s.remedy) for s in said), strict=True)
    )
    return Cause(said[0].kind, text, remedy, _evidence(dataset, found, lead)), True


def _said(
    trials: Trials,
    dataset: DataSet,
    found: Weighing,
    alike: Sequence[tuple[Suspicion, Outcome]],
) -> list[Suspicion]:
    """What is said of suspicions that differ from the likeliest in signs or size alone; nothing is none.

    A known unit or gear is said where no other factor explains the data better by as much evidence.
    Of a joint that hardly couples to others the sign of the torque and that of the position do the same.
    """
    near = [s for s, outcome in alike if not dataclasses.replace(found, before=outcome).repairs]
    best = next((s for s in near if s.kind in ("sign", "scale")), found.tried[0])
    if best.kind != "sign" or _brakes(trials, best.change):
        return [best, *(s for s in near if s.kind == "position_sign" and s is not best)]
    kept = tuple(j for j, gain in enumerate(best.change.gain) if gain > 0)
    if (_projection(trials, trials.as_logged.change).braking[list(kept)] > LEAST_SHARE).any():
        return []
    return [signs(dataset, kept)]


def _parted(found: Weighing) -> tuple[list[tuple[Suspicion, Outcome]], list[Outcome]]:
    """Suspicions that differ from the likeliest in signs or size alone, and what the others leave."""
    best, alike, rivals = found.tried[0].change, [], []
    for suspicion, outcome in zip(found.tried, found.after, strict=True):
        change = suspicion.change
        if change.differs_in_signs(best) or change.differs_in_size(best):
            alike.append((suspicion, outcome))
        else:
            rivals.append(outcome)
    return alike, rivals


def _evidence(dataset: DataSet, found: Weighing, lead: float) -> str:
    names = dataset.robot.joint_names
    shown = ", ".join(
        f"{names[j]} {found.before.relative[j]:.2g} to {found.after[0].relative[j]:.2g}"
        for j in np.flatnonzero(found.mended)
    )
    return (
        f"put right, it alone repairs the fit: residual over torque of {shown}; 2 log likelihood ratio "
        f"{found.over(found.before):.3g}, {lead:.3g} to the next such cause"
    )


def _several_signs(trials: Trials, dataset: DataSet) -> list[Suspicion]:
    """Signs reversed at several joints, up to half of them: the likeliest, then the next that repairs."""
    n = dataset.robot.n
    single = [signs(dataset, (j,)) for j in range(n)]
    best = weigh(trials, trials.as_logged, single)
    found: list[Suspicion] = []
    while len(found) + 1 < n // 2:
        best = weigh(trials, best.after[0], single)
        if not best.repairs:
            break
        gain = best.after[0].change.gain
        found.append(signs(dataset, tuple(j for j in range(n) if gain[j] < 0)))
    return found


def _brakes(trials: Trials, change: Change) -> bool:
    """Whether with these signs friction brakes, or the torque is the file's where there is none."""
    found = _projection(trials, change)
    if abs(found.friction) > LEAST_SHARE:
        return found.friction > 0
    return bool(np.sum(found.correlation[found.telling]) >= 0)


def _projection(trials: Trials, change: Change) -> Projection:
    """Of the torque that a change means."""
    righted = tuple(dataclasses.replace(r, tau=change.torque(r.tau)) for r in trials.recordings)
    return project(trials.model, {"estimation": righted})
