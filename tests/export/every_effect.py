"""Models with each effect of the catalogue in its exact form, and with free forms."""

import dataclasses
import itertools

import numpy as np

from oed.dynamics.effects.arguments import Factor, Loop, VaryingInertia
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.coordinates import Coordinate
from oed.dynamics.effects.smooth_term import SmoothTerm
from oed.export.model import Model, Origin, Ranges
from tests.dynamics.effects.arms import context_of, smooth_motion, vertical_arm
from tests.dynamics.effects.test_catalogue import USUAL

EFFECTS = (*(name for name in USUAL), "payload_change")
STEP = 3e-3  # [s]: the delay that a search begins with is a whole number of these
ORIGIN = Origin("a test", "none", "by hand", "2026-01-01", None, 0, {})


def sizes_of(name, effect):
    """Usual sizes, of as many columns as the effect has."""
    usual = itertools.cycle(USUAL.get(name, [0.3]))
    return np.array([next(usual) for _ in effect.parameters])


def augmented(context, names):
    """A context's model with effects of the catalogue in it, one after another, and its parameters."""
    parameters = context.parameters
    for name in names:
        entry = CATALOGUE[name]
        target = entry.targets(context)[-1]
        values = tuple(shape.default for shape in entry.shapes_for(context, target))
        effect = entry.build(context, target, values)
        sizes = sizes_of(name, effect)
        model = entry.apply(context, target, values, sizes)
        if len(model.parameters) > len(parameters):
            parameters = np.concatenate([parameters, sizes])
        context = dataclasses.replace(context, model=model, parameters=parameters)
    return context.model, parameters


def free_forms(joints=2):
    """One of each kind that a diagnosis may add, with coefficients."""
    q = Coordinate("q", 0, -0.8, 0.9, 8)
    dq = Coordinate("dq", 1, -1.0, 1.2, 8, from_rest=True)
    crowded = Coordinate("dq", 0, -1.0, 1.0, 6).crowded()
    time = Coordinate("time", 0, 0.0, 3.0, 5)
    forms = (
        SmoothTerm(0, (q,)),
        SmoothTerm(1, (q,), direction=1),
        SmoothTerm(1, (dq,)),
        SmoothTerm(0, (crowded,)),
        SmoothTerm(1, (q, Factor("ddq", 1))),
        SmoothTerm(1, (VaryingInertia(q),)),
        SmoothTerm(0, (Loop(0, 0.01, 0.3, 6),)),
        SmoothTerm(0, (time,), direction=0),
        SmoothTerm(1, (q, Coordinate("q", 1, -0.5, 0.5, 4))),
    )
    rng = np.random.default_rng(3)
    return forms, np.concatenate([rng.normal(size=len(f.parameters)) for f in forms])


def model_with(*names, robot=None, forms=False, duration=4.0):
    """A model as a diagnosis hands it on, and a motion to try it on."""
    robot = vertical_arm() if robot is None else robot
    motion = smooth_motion(robot, duration, STEP)
    torque_model, parameters = augmented(context_of(robot, motion), names)
    if forms:
        added, sizes = free_forms()
        torque_model = torque_model.with_effects(*added)
        parameters = np.concatenate([parameters, sizes])
    torque = torque_model.torque(parameters, motion)
    model = Model(
        torque_model,
        parameters,
        np.diag(np.linspace(1e-4, 1e-2, len(parameters))),
        parameters != 0,
        is_feasible=False,
        validity=Ranges.of([motion], [torque]),
        origin=ORIGIN,
    )
    return model, motion
