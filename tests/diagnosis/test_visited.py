"""Functions of two coordinates end where the arm has not been, if that foretells better."""

import dataclasses

import numpy as np

from oed.diagnosis.diagnosis import diagnose
from oed.diagnosis.evidence.final_model import errors_of
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis_new.rows.model_columns import effect_columns
from oed.dynamics.effects.coordinates import Coordinate
from oed.dynamics.effects.smooth_term import FreeForm
from oed.dynamics.effects.visited import CELL, Visited
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from tests.diagnosis.arm import data_set

FADING = 0.2


def _disc(rng, radius, count=20_000):
    """Points that fill a disc of a radius."""
    angle, size = rng.uniform(0, 2 * np.pi, count), radius * np.sqrt(rng.uniform(size=count))
    return np.stack([size * np.cos(angle), size * np.sin(angle)], axis=1)


def test_weight_is_one_in_the_region_and_a_gaussian_of_the_way_beyond():
    points = _disc(np.random.default_rng(0), 0.5)
    visited = Visited.of(points, FADING)
    assert np.all(visited.weight(points) == 1.0)
    angles = np.linspace(0, 2 * np.pi, 50)
    for beyond in (0.2, 0.5):
        ring = (0.5 + beyond) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        # The rim is known to the diagonal of a cell.
        off = np.sqrt(2) * CELL
        least, most = (np.exp(-(((beyond + d) / FADING) ** 2) / 2) for d in (off, -off))
        assert np.all((visited.weight(ring) >= least) & (visited.weight(ring) <= most))


def test_a_hole_in_the_region_is_beyond_it():
    points = _disc(np.random.default_rng(0), 0.5)
    ring = points[np.linalg.norm(points, axis=1) > 0.3]
    (weight,) = Visited.of(ring, FADING).weight(np.zeros((1, 2)))
    off = np.sqrt(2) * CELL
    least, most = (np.exp(-(((0.3 + d) / FADING) ** 2) / 2) for d in (off, -off))
    assert least <= weight <= most


def test_a_term_is_as_it_was_where_the_arm_has_been():
    points = _disc(np.random.default_rng(1), 0.5, 2000)
    zeros = np.zeros_like(points)
    motion = Motion(np.arange(len(points)) / 100.0, points, zeros, zeros)
    pair = tuple(Coordinate("q", joint, -0.5, 0.5, 4) for joint in range(2))
    term = FreeForm(0, pair)
    ending = dataclasses.replace(term, visited=Visited.of(points, FADING))
    assert np.array_equal(
        effect_columns(term, motion, 0.0)[0], effect_columns(ending, motion, 0.0)[0]
    )
    far = dataclasses.replace(motion, q=points + 3.0)
    assert np.all(np.abs(effect_columns(ending, far, 0.0)[0]) < 1e-12)


def test_a_landscape_seen_in_part_makes_no_other_motion_worse():
    def landscape(q, dq, ddq):
        torque = np.zeros_like(q)
        torque[:, 0] = 3.0 * np.sin(4.0 * q[:, 0] + 0.5) * np.sin(4.0 * q[:, 1] + 1.0)
        return torque

    data = data_set(2, extra=landscape, near=0.45)
    settings = DiagnosisSettings(
        surrogates=39, bootstrap=40, candidates=("joint_spring", "torque_ripple", "stribeck")
    )
    found = diagnose(data, build_model("standard", data.robot), settings)
    (term,) = (e for e in found.after.model.effects if isinstance(e, FreeForm))
    assert term.depends_on == ("q_1", "q_2")
    assert term.visited is not None
    estimation, validation, test = found.proof
    assert estimation.after[0] < 0.2 * estimation.before[0]
    for proof in (validation, test):
        assert proof.after[0] < proof.before[0]
    carried_on = dataclasses.replace(term, visited=None)
    effects = tuple(carried_on if e is term else e for e in found.after.model.effects)
    without = dataclasses.replace(found.after.model, effects=effects)
    plain = dataclasses.replace(found.after, model=without)
    unseen = found.shop.validation
    assert _spread(errors_of(found.after, unseen)) < _spread(errors_of(plain, unseen))


def _spread(errors):
    """Of the first joint [N m]."""
    return np.sqrt(np.mean(np.concatenate(errors)[:, 0] ** 2))
