"""The whole diagnosis of a data set: what a model lacks, and what adding it gains."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from threadpoolctl import threadpool_limits

from oed.diagnosis.evidence.model import Fitted
from oed.diagnosis.evidence.views import Views
from oed.diagnosis.inference.answer import Answer, FoundEffect, Outcome, Unexplained, answer
from oed.diagnosis.inference.budget import Budget, budget
from oed.diagnosis.inference.curves import Curve, curve
from oed.diagnosis.inference.disturbances import Disturbance, disturbances
from oed.diagnosis.inference.errors import Predictor, RoleErrors, compare
from oed.diagnosis.numbers import CLEAR
from oed.diagnosis.selection.search import Selected, search
from oed.diagnosis.selection.substitutes import ahead
from oed.diagnosis.setup import Sealed, pose
from oed.dynamics.effects.catalogue import CATALOGUE, CatalogueEntry
from oed.dynamics.torque_model import TorqueModel
from oed.estimation.calibration import NOTHING
from oed.estimation.known_torque import KnownTorque
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.settings import ProcessingSettings
from oed.experiment.recording import ROLES
from oed.parallel_map import cpu_seconds


@dataclass(frozen=True)
class Diagnosis:
    """What a base model lacks on a data set.

    Attributes:
        verdict: In the interface's words.
        effects: What was found and named, in the order of what it explains.
        unexplained: What is there and has no name.
        disturbances: Most of what the augmented model leaves at a joint, and no function of the motion.
        contradicted: What of that the test recordings speak against, in words; it stays named.
        before: The base model, fitted.
        after: The augmented model, fitted: an ordinary torque model.
        errors: Before and after, one entry a role that has recordings.
        budget: What each term carries on held-out rows.
        curves: What each addition gives over a coordinate on these rows.
        known: Torque that was found before: part of no model here, and of what is handed on.
        noise_floor: (n,) deviation of noise in the band [N m].
        noise_source: Where that was read off.
        cutoff: Of the analysis band [Hz].
        notes: What is doubtful about the data.
        selected: The search's own result, for whoever designs the next experiment.
    """

    verdict: Outcome
    effects: tuple[FoundEffect, ...]
    unexplained: tuple[Unexplained, ...]
    disturbances: tuple[Disturbance, ...]
    contradicted: tuple[str, ...]
    before: Predictor
    after: Predictor
    errors: tuple[RoleErrors, ...]
    budget: Budget
    curves: tuple[Curve, ...]
    known: KnownTorque
    noise_floor: Float[ndarray, " joints"]
    noise_source: str
    cutoff: float
    notes: tuple[str, ...]
    selected: Selected = field(repr=False, compare=False)


# Thousands of small matrices: more threads of BLAS wait for one another, and take twice as long.
@threadpool_limits.wrap(limits=1)
def diagnose(
    dataset: DataSet,
    model: TorqueModel,
    *,
    settings: ProcessingSettings | None = None,
    catalogue: Mapping[str, CatalogueEntry] = CATALOGUE,
    names: Sequence[str] | None = None,
    most: int | None = None,
    parameters: Float[ndarray, " parameters"] | None = None,
    known: KnownTorque = NOTHING,
    noise_of: TorqueModel | None = None,
    seed: int = 0,
    budget: float | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Find what a torque model lacks, from a data set alone.

    Args:
        dataset: Recordings with roles. The search sees those for estimation and validation; those
            for the test only report.
        model: The base model.
        settings: How recordings are processed; chosen from them if None.
        catalogue: Effects that may be named.
        names: Of these, those that are tried; all if None.
        most: Terms that may be added; three a joint if None, at least six.
        parameters: Of the base model, where it was found before: errors before are those of this
            estimate, handed on as it is; estimated from the data set if None.
        known: Torque that was found before and stays as it is, such as that of smooth terms.
        noise_of: Model beside which the noise is read off: where `model` was found before, the data
            set's own base model, as it was then; `model` if None.
        seed: Of the bootstrap.
        budget: CPU time after which nothing more is looked for [s]; what was found by then is judged
            and reported.
        say: Receives lines of progress.

    Raises:
        ValueError: If there is no estimation recording, or one is too short.
        OedError: If a joint stands still, or friction drives every joint.
    """
    end = cpu_seconds() + (np.inf if budget is None else budget)
    problem, sealed, notes = pose(
        dataset,
        model,
        settings,
        catalogue=catalogue,
        names=names,
        most=most,
        known=known,
        noise_of=noise_of,
        say=say,
    )
    for note in notes:
        say(f"note: {note}")
    selected = search(problem, say, lambda: cpu_seconds() > end)
    if cpu_seconds() > end:
        spent = f"the search ended when its {budget:g} s of CPU time were over: more may find more"
        notes = (*notes, spent)
        say(f"note: {spent}")
    found = answer(selected)
    before = Predictor(sealed.before.model, sealed.before.parameters)
    return report(
        sealed,
        selected,
        found,
        before=before if parameters is None else Predictor(model, parameters),
        notes=notes,
        rng=np.random.default_rng(seed),
    )


def report(
    sealed: Sealed,
    selected: Selected,
    found: Answer,
    *,
    before: Predictor,
    notes: tuple[str, ...],
    rng: np.random.Generator,
) -> Diagnosis:
    """Errors on all recordings, the sealed ones too: nothing that was found changes by it."""
    views = ahead(selected.views, selected.views.terms)
    whole = views.told
    after = predictor(whole) if whole.terms else before
    by_role = {role: tuple(p for p in sealed.every if p.role == role) for role in ROLES}
    errors = tuple(
        compare(role, own, sealed.weights(own), before=before, after=after, rng=rng)
        for role, own in by_role.items()
        if own
    )
    role = next(r for r in ("validation", "test", "estimation") if by_role[r])
    shown = by_role[role]
    labels = [(term.label, predictor(_less(views, k))) for k, term in enumerate(whole.terms)]
    carried = budget(
        role,
        shown,
        sealed.weights(shown),
        after,
        labels=labels,
        floor=sealed.floor,
        base=len(views.problem.base.effects),
    )
    drawn = [
        curve(
            label,
            shown,
            after=after,
            rest=rest,
            coordinates=term.candidate.effect(whole.context, term.values).depends_on,
            floor=sealed.floor,
        )
        for term, (label, rest) in zip(whole.terms, labels, strict=True)
    ]
    # Where something hit the arm may be in any recording; those for the test have no say here either.
    looked_at = (*by_role["estimation"], *by_role["validation"])
    disturbed = disturbances(looked_at, sealed.weights(looked_at), after)
    unexplained = (
        *found.unexplained,
        *(Unexplained(d.joint, ("time",), d.words, None) for d in disturbed),
    )
    unexplained += _unlocated(unexplained, errors, sealed.floor)
    return Diagnosis(
        _verdict(found.effects, unexplained),
        found.effects,
        unexplained,
        disturbed,
        _contradicted(views, found, by_role["test"], sealed, after),
        before,
        after,
        errors,
        carried,
        tuple(c for c in drawn if c is not None),
        sealed.before.known,
        sealed.floor,
        sealed.source,
        sealed.every[0].band.cutoff,
        notes,
        selected,
    )


def predictor(fitted: Fitted) -> Predictor:
    """The fitted model as an ordinary torque model."""
    sizes = [size for _, size in fitted.added]
    return Predictor(fitted.torque_model, np.concatenate([fitted.parameters, *sizes]))


def _less(views: Views, number: int) -> Fitted:
    """The same numbers without one term: what is lost is what it carries."""
    whole = views.told
    if whole.terms[number].steps:
        return _refitted_without(views, number)
    coefficients = whole.projection.coefficients.copy()
    coefficients[whole.places[number]] = 0.0
    return dataclasses.replace(
        whole, projection=dataclasses.replace(whole.projection, coefficients=coefficients)
    )


def _refitted_without(views: Views, number: int) -> Fitted:
    return ahead(views, views.others(number)).told


def _unlocated(
    unexplained: Sequence[Unexplained],
    errors: Sequence[RoleErrors],
    floor: Float[ndarray, " joints"],
) -> tuple[Unexplained, ...]:
    """Joints where the search saw errors that no noise explains, and nothing is said of it yet."""
    said = {u.joint for u in unexplained}
    seen = np.max([e.after for e in errors if e.role != "test"], axis=0)
    return tuple(
        Unexplained(int(j), (), "something that no term that was tried describes", None)
        for j in np.flatnonzero(seen > CLEAR * floor)
        if int(j) not in said
    )


def _verdict(effects: Sequence[FoundEffect], unexplained: Sequence[Unexplained]) -> Outcome:
    if unexplained:
        return "unexplained"
    if any(effect.is_open for effect in effects):
        return "ambiguous"
    return "explained" if effects else "nothing found"


def _contradicted(
    views: Views, found: Answer, test: Sequence, sealed: Sealed, after: Predictor
) -> tuple[str, ...]:
    """Names without which the test recordings are predicted better, joints together, in words."""
    if not test:
        return ()
    weights = sealed.weights(test)

    def error(model: Predictor) -> float:
        squares = [
            np.sum((model.errors(p) / sealed.floor) ** 2 * w)
            for p, w in zip(test, weights, strict=True)
        ]
        return float(np.sqrt(np.sum(squares) / np.sum([w.sum() for w in weights])))

    with_all, words = error(after), []
    for effect in found.effects:
        rest = error(predictor(_refitted_without(views, effect.number)))
        if rest < with_all:
            words.append(
                f"the test recordings contradict {views.terms[effect.number].label}: their error is "
                f"{with_all:.3g} noise floors with it and {rest:.3g} without"
            )
    return tuple(words)
