"""Each registered claim held against what was drawn: designs, test motions and noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from studies.paper_experiment import claims as c
from studies.paper_experiment import energy
from studies.paper_experiment import values as paper
from studies.paper_experiment.campaign import FITS, WAYS, Campaign
from studies.paper_experiment.designs import CRITERIA, KINDS
from studies.paper_experiment.fitting import XI, infeasible
from studies.paper_experiment.laboratory import FRICTIONS, JOINTS
from studies.paper_experiment.random_effects import (
    Interval,
    Sources,
    mean_interval,
    rate_interval,
    sources_of,
)
from studies.paper_experiment.searches import Searches

J_K, J_D = KINDS.index("J_k, GA"), KINDS.index("J_d, GA")
GAMMA_S1 = 4
PAPER_FIT, FILTERED_FIT, RICHER_FIT = range(len(FITS))
JUDGED = ("online", "parallel")  # the paper's signals, and those that bias least
ANY = "-"  # of a finding that no friction or no processing of signals takes part in


@dataclass(frozen=True)
class Finding:
    """One measured answer to a claim.

    Attributes:
        claim: Which.
        friction: Of the arm.
        signals: How they were processed.
        detail: Joint, criterion or settings.
        interval: Of the quantity.
        sources: Of its spread; None where noise takes no part. In per cent for a ratio.
    """

    claim: c.Claim
    friction: str
    signals: str
    detail: str
    interval: Interval
    sources: Sources | None = None

    @property
    def verdict(self) -> c.Verdict:
        """On the claim."""
        return self.claim.verdict(self.interval)


def measured(
    claim: c.Claim, where: tuple[str, str, str], y: Float[ndarray, "P T E"], *, drawn: bool = True
) -> Finding:
    """A finding from the values, or logarithms of ratios, of many experiments.

    Args:
        claim: Which.
        where: Friction, signals, detail.
        y: Values.
        drawn: Whether they differ by a draw of the noise too.
    """
    is_ratio = claim.unit == "ratio"
    found = mean_interval(y)
    if is_ratio:
        found = Interval(*(float(np.exp(x)) for x in (found.value, found.lower, found.upper)))
    sources = sources_of(100 * y if is_ratio else y) if drawn else None
    return Finding(claim, *where, found, sources)


def of_searches(searches: Searches) -> Iterator[Finding]:
    """On the algorithm alone: how soon it ends, how many sines, which J_d."""
    kinds = {name: found for name, found in searches.runs.items() if name[0] != "J_d"}
    shortest = min(found.generations for found in kinds.values())
    for (fitness, population), found in kinds.items():
        for end in sorted({shortest, found.generations}):
            near = found.best[:, : paper.GENERATIONS] <= 1.05 * found.best[:, end, None]
            detail = f"fitness {fitness}, {population} individuals, end after {end} generations"
            interval = rate_interval(np.array(near.any(axis=1))[:, None])
            yield Finding(c.GENERATIONS, ANY, ANY, detail, interval)
    three, five = searches.condition.best[:, -1], searches.more_terms.best[:, -1]
    ratio = np.log(five / three[: len(five)])
    yield measured(c.TERMS, (ANY, ANY, "five sines"), ratio[:, None, None], drawn=False)
    ends = (
        ("at all instants", searches.determinant.best[:, -1]),
        ("at half of them", searches.half),
    )
    for detail, values in ends:
        y = (values - paper.J_D)[:, None, None]
        yield measured(c.DETERMINANT, (ANY, ANY, detail), y, drawn=False)


def of_speed(speed: Float[ndarray, "K P n"]) -> Iterator[Finding]:
    """On how fast designs move."""
    ratio = np.log(speed[J_D] / speed[J_K])
    for j in range(JOINTS):
        y = ratio[:, j, None, None]
        yield measured(c.SPEED, (ANY, ANY, f"joint {j + 1}"), y, drawn=False)


def of_campaign(found: Campaign, truth: Float[ndarray, "8"]) -> Iterator[Finding]:
    """On experiments."""
    for f, friction in enumerate(FRICTIONS):
        yield from _variance(found, f)
        for w, way in enumerate(WAYS):
            yield from _static_friction(found, f, w)
            if way in energy.WAYS:
                yield from _energy(found, f, w, truth)
            if way in JUDGED:
                yield from _criteria(found, f, w)
                yield from _infeasible(found, f, w)
                if friction == "plain":
                    # Here the model is right: what is judged is the estimate, not its bias.
                    yield from _covariance(found, f, w)
                    yield from _exact_limits(found, f, w, truth)
                else:
                    yield from _richer_friction(found, f, w)


def _where(f: int, w: int, detail: str) -> tuple[str, str, str]:
    return FRICTIONS[f], WAYS[w], detail


def _variance(found: Campaign, f: int) -> Iterator[Finding]:
    logs = np.log(found.variances[f, J_D, :, :, 0] / found.variances[f, J_K, :, :, 0])
    for j in range(JOINTS):
        where = (FRICTIONS[f], ANY, f"joint {j + 1}")
        yield measured(c.VARIANCE, where, logs[:, None, :, j])


def _static_friction(found: Campaign, f: int, w: int) -> Iterator[Finding]:
    estimates = found.parameters[f, :, :, :, w, PAPER_FIT, GAMMA_S1]
    y = estimates[J_K] - estimates[J_D]
    yield measured(c.STATIC_FRICTION, _where(f, w, "joint 1"), y[:, None])


def _criteria(found: Campaign, f: int, w: int) -> Iterator[Finding]:
    own = 100 * found.relative[f, :, :, :, w, 1]
    test = 100 * found.test_relative[f, :, :, :, :, w, PAPER_FIT]
    for j in range(JOINTS):
        where = _where(f, w, f"joint {j + 1}")
        yield measured(c.VALIDATION, where, (own[J_K] - own[J_D])[:, None, :, j])
        yield measured(c.PREDICTION, where, (test[J_K] - test[J_D])[..., j])


def _infeasible(found: Campaign, f: int, w: int) -> Iterator[Finding]:
    xi = found.parameters[f, [J_K, J_D], :, :, w, PAPER_FIT, :XI]
    hits = infeasible(xi).reshape(-1, xi.shape[2])
    where = _where(f, w, "designs for J_k and J_d")
    yield Finding(c.INFEASIBLE, *where, rate_interval(hits))


def _richer_friction(found: Campaign, f: int, w: int) -> Iterator[Finding]:
    test = 100 * found.test_relative[f, :, :, :, :, w]
    gain = test[..., RICHER_FIT, :] - test[..., PAPER_FIT, :]
    for k in (J_K, J_D):
        for j in range(JOINTS):
            detail = f"{CRITERIA[k]} designs, joint {j + 1}"
            yield measured(c.FRICTION, _where(f, w, detail), gain[k][..., j])


def _energy(found: Campaign, f: int, w: int, truth: Float[ndarray, "8"]) -> Iterator[Finding]:
    torque = found.parameters[f, J_K, :, :, w, PAPER_FIT, :XI]
    work = found.energy[f, :, :, energy.WAYS.index(WAYS[w])]
    y = np.log(rms_relative(work - truth, truth) / rms_relative(torque - truth, truth))
    yield measured(c.ENERGY, _where(f, w, "J_k designs"), y[:, None])


def _covariance(found: Campaign, f: int, w: int) -> Iterator[Finding]:
    for fit, name in ((PAPER_FIT, "R_v as logged"), (FILTERED_FIT, "R_v as filtered")):
        for k in (J_K, J_D):
            xi = found.parameters[f, k, :, :, w, fit, :XI]
            mean_P = found.covariance[f, k, :, :, w, fit].mean(axis=1)
            # The squared length of a deviation in units of P: its mean is 8 if P is right.
            away = xi - xi.mean(axis=1, keepdims=True)
            squares = np.einsum("pei,pij,pej->p", away, np.linalg.inv(mean_P), away)
            y = 0.5 * np.log(squares / (XI * (xi.shape[1] - 1)))
            where = _where(f, w, f"{CRITERIA[k]} designs, {name}")
            yield measured(c.COVARIANCE, where, y[:, None, None], drawn=False)


def _exact_limits(found: Campaign, f: int, w: int, truth: Float[ndarray, "8"]) -> Iterator[Finding]:
    test = 100 * found.test_relative[f, :, :, :, :, w, PAPER_FIT]
    error = np.log(rms_relative(found.parameters[f, ..., w, PAPER_FIT, :XI] - truth, truth))
    for k, criterion in enumerate(CRITERIA):
        exact = KINDS.index(f"{criterion}, exact limits")
        where = _where(f, w, f"{criterion} designs")
        yield measured(c.EXACT_ERROR, where, (error[exact] - error[k])[:, None])
        for j in range(JOINTS):
            where = _where(f, w, f"{criterion} designs, joint {j + 1}")
            yield measured(c.EXACT_PREDICTION, where, (test[exact] - test[k])[..., j])


def rms_relative(
    error: Float[ndarray, "*cells 8"], truth: Float[ndarray, "8"]
) -> Float[ndarray, "*cells"]:
    """Root mean square over the parameters of errors relative to the truth."""
    return np.sqrt(((error / truth) ** 2).mean(axis=-1))
