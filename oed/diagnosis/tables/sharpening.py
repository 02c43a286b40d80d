"""The tables anew, with signs and a noise floor read off beside what was added."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.tables.joint_sign import is_law_of_speed, with_signs_fitted_together
from oed.diagnosis.tables.predict import fine_torque
from oed.diagnosis.tables.workbench import Augmented, added_columns, lags_of
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.climbing import climb
from oed.diagnosis.terms.scores import scan
from oed.diagnosis.terms.trials import Trial
from oed.diagnosis_new.noise.baseline import Baseline
from oed.diagnosis_new.noise.sign_width import with_fitted_sign
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import signs_of, turn_alike, with_signs, with_widths


def sharpened(shop: Workshop, chosen: Sequence[Trial]) -> Workshop | None:
    """Tables with signs and a noise floor read off beside these additions.

    None where neither changes enough to matter. What the first fit could not explain may
    have passed for a sign that turns slowly, and without repetitions for noise.
    """
    old = shop.baseline
    found = shop.fit(chosen, shop.layout_for(chosen))
    model = _foretelling(shop, _signs_beside(shop, found), chosen)
    baseline = old.with_model(model, shop.estimation, _known(shop, found))
    floor = baseline.floor.quietest(old.floor)
    baseline = dataclasses.replace(baseline, floor=floor)
    if turn_alike(model, old.model) and not floor.is_below(old.floor):
        return None
    return shop.on(baseline)


def _signs_beside(shop: Workshop, found: Augmented) -> TorqueModel:
    """The base model with the signs that fit best beside additions."""
    layout = shop.layout_for(found.chosen)
    # From the sharpest on: a width that stood in for what is now added must come back.
    sharpest = _sharpest(shop.baseline, shop.baseline.model)
    late = with_fitted_sign(
        sharpest.with_measurement(*lags_of(found.chosen)),
        shop.baseline.columns,
        layout.rows,
        added_columns(found, layout, shop.context),
    )
    model = dataclasses.replace(late, measurement=sharpest.measurement)
    return with_signs_fitted_together(shop.baseline, model, layout, found.chosen, shop.context)


def _sharpest(baseline: Baseline, model: TorqueModel) -> TorqueModel:
    return with_widths(model, baseline.least_widths)


def _foretelling(shop: Workshop, model: TorqueModel, chosen: Sequence[Trial]) -> TorqueModel:
    """A model with those of its slow signs that the validation recordings bear.

    A motion that seldom turns slowly hardly tells how a sign turns; another may.
    """
    sharp = _sharpest(shop.baseline, model)
    if not shop.validation or turn_alike(sharp, model):
        return model
    tables = [_standing_on(shop, m) for m in (model, sharp)]
    lead = lead_of(*((own, _with_laws_refined(own, chosen)) for own in tables))
    kept = np.flatnonzero(lead >= 0).tolist()
    signs = signs_of(sharp).items()
    return with_signs(model, {joint: sign for joint, sign in signs if joint not in kept})


def _with_laws_refined(shop: Workshop, chosen: Sequence[Trial]) -> list[Trial]:
    """Additions on these tables, laws of low speed at the shapes that they want beside the signs here."""
    own, _ = shop.settle(chosen)
    for k, trial in enumerate(own):
        if is_law_of_speed(trial) and trial.shapes:
            fit = shop.fit([t for t in own if t is not trial], shop.layout(trial)).fit
            grid = shop.candidates(trial.name, trial.target)
            (start,) = scan([trial, *grid], fit, shop.context)
            own[k] = climb(start, fit, shop.context).trial
    return own


def lead_of(
    one: tuple[Workshop, Sequence[Trial]], other: tuple[Workshop, Sequence[Trial]]
) -> Float[ndarray, " joints"]:
    """(n,) by how much one model explains and foretells more than another, in -2 log likelihood.

    Squares count in units of what the better one leaves, for both may lack other things.

    Args:
        one: Tables, and additions to their model.
        other: The same recordings in the same noise under another model.
    """
    squares = [_squares(*each) for each in (one, other)]
    shop, chosen = max((one, other), key=lambda each: len(each[1]))
    counted = np.stack([shop.layout_for(chosen).rows.counted, shop.unseen_by(chosen).counted])
    unit = np.maximum(np.minimum(*squares) / np.maximum(counted, 1.0), 1.0)
    return np.sum((squares[1] - squares[0]) / unit, axis=0)


def with_own_sign(shop: Workshop, joint: int | None, chosen: Sequence[Trial]) -> Workshop | None:
    """Tables with a joint's sign as it is beside these additions, all else as it stands.

    None where it turns alike.
    """
    model = _foretelling(shop, _signs_beside(shop, shop.fit(chosen)), chosen)
    own = {j: sign for j, sign in signs_of(model).items() if j == joint}
    turned = with_signs(shop.baseline.model, own)
    return None if turn_alike(turned, shop.baseline.model) else _standing_on(shop, turned)


def _standing_on(shop: Workshop, model: TorqueModel) -> Workshop:
    """The same tables, in the same noise, with another base model."""
    return shop.on(dataclasses.replace(shop.baseline, model=model))


def _squares(shop: Workshop, chosen: Sequence[Trial]) -> Float[ndarray, "2 joints"]:
    """White squares that a model leaves of the recordings, fitted and foretold."""
    own, _ = shop.settle(chosen)
    found = shop.fit(own, bend=False)
    fitted = np.sum(found.fit.residual**2, axis=1)
    return np.stack([fitted, shop.unseen_by(chosen).left(found)])


def _known(shop: Workshop, found: Augmented) -> list[Float[ndarray, "_ joints"]]:
    """Torque of additions on the fine grids [N m]."""
    pairs = list(zip(found.chosen, found.coefficients, strict=True))
    return [
        sum((fine_torque(t, c, p) for t, c in pairs), np.zeros_like(p.fine_torque))
        for p in shop.estimation
    ]
