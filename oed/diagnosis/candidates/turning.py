"""A base that is mounted otherwise than declared: the tables turned to where gravity points.

The columns of a tilt hold for small ones, and for parameters that a wrong gravity has not spoilt.
So the whole base model is refitted under other directions, first far ones, then by Gauss and
Newton's steps; first moments that only the true direction shows join its base parameters.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from itertools import product

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.diagnosis.candidates.accepted import Accepted, at_home
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import Trial, catalogue_trial
from oed.diagnosis_new.noise.baseline import Baseline
from oed.diagnosis_new.noise.linear_fit import LinearFit, span_of_model
from oed.dynamics.effects import RigidBody
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.gravity import tilt_between, tilt_directions, tilted
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.parallel_map import side_by_side
from oed.robot.inertia import PARAMETER_SYMBOLS

GRAVITY = "gravity_direction"
FAR = np.deg2rad((30.0, 60.0, 90.0, 135.0, 180.0))  # tilts that are tried at once
FIRST_MOMENTS = ("mx", "my", "mz")
SECOND_MOMENTS = (4, 7, 9)  # places of Ixx, Iyy and Izz among a link's parameters
SETTLED = 1e-4  # [rad] of a step, after which the direction is taken for found
MOST_STEPS = 8
LARGEST_STEP = 0.5  # [rad]
LEVEL = 1.001  # ratio of squares up to which two directions fit alike
HEAVIEST = 1000.0  # [kg] of a link, beyond every arm on the market
HEAVIER = 5.0  # times what the whole arm is declared to weigh
CLEARLY_BETTER = 0.5  # share of the squares that a far direction may leave


def _gravity_trial(shop: Workshop) -> Trial:
    """The tilt's columns at the direction that the tables have."""
    return catalogue_trial(CATALOGUE[GRAVITY], shop.context, None, (), shop.mean.rows)


def far_turned(shop: Workshop) -> Workshop | None:
    """The tables turned to a far direction under which the base model fits far better."""
    declared = shop.baseline.model.robot.gravity
    axes = len(tilt_directions(declared)[0])
    if axes != 2 or all(t.name != GRAVITY for t in shop.physical):
        return None
    models = [
        _under_tilt(shop.baseline.model, angle * np.array([np.cos(heading), np.sin(heading)]))
        for angle, heading in product(FAR, np.arange(4) * np.pi / 2)
    ]
    squares = side_by_side(lambda model: squares_under(shop, model), models)
    best = int(np.argmin(squares))
    if squares[best] > CLEARLY_BETTER * shop.before.fit.squares:
        return None
    found = _smaller_of_mirrored(turned(_rebuilt(shop, models[best]), ()))
    old, new = shop.validation_rms(shop.before), found.validation_rms(found.before)
    if old is not None and new is not None and np.mean((new / old) ** 2) >= 1:
        return None
    # One step of Gauss and Newton cannot come back from there: let the declared one try, too.
    return found if found.before.fit.squares < CLEARLY_BETTER * shop.before.fit.squares else None


def accepted_tilt(shop: Workshop, declared: Workshop) -> Accepted:
    """The tilt as an addition to turned tables: what is left of it, its gain over declared ones."""
    gain = declared.before.fit.squares - shop.before.fit.squares
    return Accepted(_gravity_trial(shop), max(gain, 0.0))


def moment_fault(shop: Workshop, fit: LinearFit) -> str | None:
    """Whether what only the tilt shows would need a link of impossible mass.

    A tilt of a hundredth of a degree makes a torque of any size if the first moment may be
    large enough. But the mass is at least that moment squared over the moment of inertia.
    """
    inertial = dict(zip(shop.baseline.columns, fit.parameters, strict=False))
    declared = float(np.sum(shop.declared.model.robot.parameters[::10]))
    heaviest = min(HEAVIER * declared, HEAVIEST) if declared > 0 else HEAVIEST
    for column in set(shop.baseline.columns) - set(shop.declared.columns):
        link, symbol = int(column) // 10, PARAMETER_SYMBOLS[int(column) % 10]
        second = [abs(inertial.get(10 * link + k, 0.0)) for k in SECOND_MOMENTS]
        if symbol in FIRST_MOMENTS and inertial[column] ** 2 > heaviest * max(second):
            return f"{symbol} of link {link + 1} would be {inertial[column]:.3g} kg m"
    return None


def total_tilt(
    shop: Workshop, tilt: Float[ndarray, " directions"]
) -> Float[ndarray, " directions"]:
    """A tilt of turned tables, counted from the declared gravity [rad]."""
    here = shop.baseline.model.robot.gravity
    return tilt_between(shop.declared.model.robot.gravity, tilted(here, tilt))


def turned(shop: Workshop, others: Sequence[Trial]) -> Workshop:
    """The tables turned to the direction that fits best beside other additions.

    Where moments that only a tilt shows would have to be impossible, something else is missing
    that they make up for: the tilt does without them until that is found.
    """
    found = _at_best_tilt(_with_moments(shop), others)
    if not found.is_turned or moment_fault(found, found.fit(others, found.mean).fit) is None:
        return found
    bare = _at_best_tilt(_rebuilt(shop, shop.baseline.model, bare=True), others, bare=True)
    full = _at_best_tilt(_with_moments(bare), others)
    return bare if moment_fault(full, full.fit(others, full.mean).fit) else full


def turned_beside(shop: Workshop, accepted: Sequence[Accepted]) -> tuple[Workshop, list[Accepted]]:
    """The same beside additions as far as they stand, and the additions on those tables."""
    shop = turned(shop, [a.trial for a in accepted if a.stands_in])
    return shop, [at_home(shop, a) for a in accepted]


def _with_moments(shop: Workshop) -> Workshop:
    """Turned tables with all base parameters that the tilt shows."""
    if not shop.is_turned:
        return shop
    columns = np.sort(base_parameters(shop.baseline.model).columns)
    same = np.array_equal(columns, shop.baseline.columns)
    return shop if same else _rebuilt(shop, shop.baseline.model)


def _at_best_tilt(shop: Workshop, others: Sequence[Trial], *, bare: bool = False) -> Workshop:
    """Gauss and Newton's steps to the direction that fits best, without further moments if bare.

    A step that explains less is halved: moments that only the tilt shows multiply it. All are
    compared in the noise of the tables as they were.
    """
    start, (own, left) = shop, shop.settle(others, shop.mean)
    for _ in range(MOST_STEPS):
        trial = _gravity_trial(shop)
        coefficients = shop.fit([*own, trial], shop.mean, bend=False).coefficients[-1]
        step = coefficients[: len(tilt_directions(shop.baseline.model.robot.gravity)[0])]
        length = float(np.linalg.norm(step))
        step = step * min(1.0, LARGEST_STEP / max(length, SETTLED))
        while np.linalg.norm(step) >= SETTLED:
            model = _under_tilt(shop.baseline.model, step)
            there = shop.on(_with_columns(shop, model, bare=bare))
            renewed, less = there.settle(own, there.mean)
            if less < left:
                break
            step = step / 2
        else:
            break
        shop, own, left = there, renewed, less
    if shop is start:
        return shop
    found = _rebuilt(shop, shop.baseline.model, bare=bare)
    found.settle(own, found.mean)
    return found


def _smaller_of_mirrored(shop: Workshop) -> Workshop:
    """The smaller of two tilts that an arm in a plane cannot tell apart."""
    declared = shop.declared.model.robot.gravity
    here = shop.baseline.model.robot.gravity
    up = declared / np.linalg.norm(declared)
    if here @ up >= 0:
        return shop
    back = tilt_between(here, here - 2 * (here @ up) * up)
    mirrored = _under_tilt(shop.baseline.model, back)
    same = squares_under(shop, mirrored) < LEVEL * shop.before.fit.squares
    return _rebuilt(shop, mirrored) if same else shop


def _rebuilt(shop: Workshop, model: TorqueModel, *, bare: bool = False) -> Workshop:
    """The tables of another model in the noise that it leaves."""
    baseline = _with_columns(shop, model, bare=bare).with_model(model, shop.estimation)
    return shop.on(baseline)


def _with_columns(shop: Workshop, model: TorqueModel, *, bare: bool) -> Baseline:
    """Another model, with the declared one's base parameters if bare, in the noise of the tables."""
    columns = shop.declared.columns if bare else np.sort(base_parameters(model).columns)
    return dataclasses.replace(shop.baseline, model=model, columns=columns)


def _under_tilt(model: TorqueModel, tilt: Float[ndarray, " directions"]) -> TorqueModel:
    robot = model.robot.with_gravity(tilted(model.robot.gravity, tilt))
    effects = tuple(RigidBody(robot) if isinstance(e, RigidBody) else e for e in model.effects)
    return dataclasses.replace(model, robot=robot, effects=effects)


def squares_under(shop: Workshop, model: TorqueModel) -> float:
    """Whitened squares that a base model leaves, on the mean rows of the tables."""
    rows = shop.mean.rows
    span = span_of_model(model, np.sort(base_parameters(model).columns), rows)
    return float(np.sum(span.residual(rows.torque()) ** 2))
