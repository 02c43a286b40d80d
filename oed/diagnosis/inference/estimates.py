"""Parameters of a term with standard deviations, shapes and sizes together."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.candidate import Values
from oed.diagnosis.evidence.columns import white_effect
from oed.diagnosis.evidence.model import Fitted
from oed.dynamics.effects.catalogue import Shape

STEP = 1e-3  # of a shape's range: of central differences


@dataclass(frozen=True)
class Estimated:
    """A parameter of an effect.

    Attributes:
        name: Symbol in words.
        value: In `unit`.
        std: Standard deviation; None where the recordings do not say it.
        unit: SI unit.
        note: In words why there is none.
    """

    name: str
    value: float
    std: float | None
    unit: str
    note: str | None = None


def estimates(whole: Fitted, number: int, dilution: float) -> tuple[Estimated, ...]:
    """Sizes of a term, then its shapes, each with what all other parameters leave open.

    Gauss-Newton: the information of the columns beside all else, with the derivative by each shape
    among them, times the dilution (Huber 1967; Seber and Wild 1989, section 2.1).

    Args:
        whole: The fitted model.
        number: Of the term.
        dilution: Rows that tell as much as one.
    """
    term, place = whole.terms[number], whole.places[number]
    own = {j: c[:, place] for j, c in enumerate(whole.projection.columns)}
    slopes, moving = _slopes(whole, number)
    count = place.stop - place.start
    columns = {j: np.concatenate([own[j], slopes[j]], axis=1) for j in own}
    keep = np.ones(whole.projection.columns.shape[2], dtype=bool)
    keep[place] = False
    information = _information(whole, keep, columns)
    lengths = np.sqrt(np.maximum(np.diag(information), 1e-300))
    scaled = information / np.outer(lengths, lengths)
    variance = np.diag(np.linalg.pinv(scaled, rcond=1e-10)) / lengths**2 * dilution
    std = np.sqrt(np.maximum(variance, 0.0))
    total = whole.size(number)[:count]
    effect = whole.effects[number]
    names = () if effect is None else effect.parameters
    found = [
        Estimated(p.name, float(v), float(s), p.unit)
        for p, v, s in zip(names, total, std[:count], strict=True)
    ]
    shapes = term.candidate.shapes(whole.context)
    deviations = dict(zip(moving, std[count:].tolist(), strict=True))
    for k, (shape, value) in enumerate(zip(shapes, term.values, strict=True)):
        found.append(_shape(shape, value, deviations.get(k)))
    return tuple(found)


def _shape(shape: Shape, value: float, std: float | None) -> Estimated:
    if std is None:
        note = (
            "for good"
            if shape.is_idle(value)
            else "as in the plain formula"
            if shape.is_plain(value)
            else "chosen, not estimated"
        )
        return Estimated(shape.name, float(value), None, shape.unit, note)
    wide = (shape.upper - shape.lower) / np.sqrt(12)
    if std > wide:
        return Estimated(
            shape.name,
            float(value),
            None,
            shape.unit,
            f"open between {shape.lower:.3g} and {shape.upper:.3g}",
        )
    return Estimated(shape.name, float(value), std, shape.unit)


def _slopes(whole: Fitted, number: int) -> tuple[dict[int, ndarray], list[int]]:
    """White derivative of a term's torque by each shape that is estimated."""
    term, sizes, rows = whole.terms[number], whole.coefficients[number], whole.problem.rows
    shapes = term.candidate.shapes(whole.context)
    moving = [
        k
        for k, (shape, value) in enumerate(zip(shapes, term.values, strict=True))
        if shape.is_estimated
        and not shape.is_plain(value)
        and not shape.is_idle(value)
        and shape.lower <= value <= shape.upper
        and shape.upper > shape.lower
    ]
    amount = np.ones(1) if term.candidate.unit_coefficient else sizes
    context = whole.context
    if term.steps:
        context = dataclasses.replace(context, model=whole.problem.base)
        if not term.candidate.unit_coefficient:
            amount = whole.size(number)

    def torque(values: Values) -> dict[int, ndarray]:
        effect = term.candidate.effect(context, values)
        model = context.model if term.steps else whole.installed
        white = white_effect(effect, model, rows)
        return {j: c @ amount for j, c in white.items()}

    result = {j: np.zeros((rows.torque.shape[1], len(moving))) for j in range(rows.joints)}
    for column, k in enumerate(moving):
        shape, place = shapes[k], shapes[k].place_of(term.values[k])
        ends = [shape.at(min(max(place + s, 0.0), 1.0)) for s in (STEP, -STEP)]
        high, low = (torque((*term.values[:k], end, *term.values[k + 1 :])) for end in ends)
        zero = np.zeros(rows.torque.shape[1])
        for j, slopes in result.items():
            slopes[:, column] = (high.get(j, zero) - low.get(j, zero)) / (ends[0] - ends[1])
    return result, moving


def _information(
    whole: Fitted, keep: ndarray, columns: dict[int, ndarray]
) -> Float[ndarray, "columns columns"]:
    """X' V^-1 X of columns beside some columns of the model, over the rows that were fitted."""
    projection = whole.projection
    weights, used = projection.weights, projection.used
    joints = range(whole.problem.rows.joints)
    D = np.concatenate([projection.columns[j][used][:, keep] * weights[j] for j in joints])
    X = np.concatenate([columns[j][used] * weights[j] for j in joints])
    rows = len(D)
    priors = np.zeros((D.shape[1], D.shape[1]))
    start = np.cumsum(keep) - 1
    for term, place in zip(whole.terms, whole.places, strict=True):
        if term.precision is not None and keep[place].all() and place.stop > place.start:
            at = start[place]
            priors[np.ix_(at, at)] = term.precision
    values, vectors = np.linalg.eigh(priors)
    D = np.concatenate([D, (vectors * np.sqrt(np.maximum(values, 0.0))).T])
    lengths = np.linalg.norm(D, axis=0)
    u, s, _ = np.linalg.svd(D / np.where(lengths > 0, lengths, 1.0), full_matrices=False)
    basis = u[:rows, s > 1e-7 * s.max()]
    inside = basis.T @ X
    return X.T @ X - inside.T @ inside
