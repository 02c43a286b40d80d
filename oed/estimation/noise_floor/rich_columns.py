"""What a rich fit of a joint is made of: filtered columns of smooth terms, and of a model.

What a term depends on does not know the joint that it acts on: what two joints share is worked out
once.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from functools import lru_cache

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import block_diag

from oed.dynamics.effects.smooth_term import SmoothTerm
from oed.dynamics.velocity_sign import WIDTH_PER_SIGMA
from oed.estimation.noise_floor.linear_fit import LinearFit, effect_columns
from oed.estimation.noise_floor.smooth_terms import PIECES_FINE, coordinate, loop, terms_together
from oed.experiment.preparation.prepared import Prepared

# Pieces that crowd about this share of a joint's largest speed: friction falls from rest.
PIECES_SLOW, SLOW = 12, 0.01
LEAST_WIDTH = 1e-9  # [rad/s] of a sign, where encoders have no noise
REMEMBERED = 16  # joints whose terms are kept
KEPT_BYTES = 256_000_000  # of terms' columns; those of more terms are worked out at each fit

Recordings = tuple[Prepared, ...]

# By recordings and what a term is made of; of one set of recordings at a time.
_kept: dict[tuple[Recordings, Hashable], Float[ndarray, "rows columns"]] = {}


def lay_out(prepared: Recordings) -> None:
    """Work out what all rich fits of some recordings share, for processes that fork to have it."""
    for joint in range(prepared[0].torque.shape[1]):
        first_blocks(prepared, joint)
        further_blocks(prepared, joint)


def forget() -> None:
    """Give back what rich fits of a data set share: columns of all rows."""
    _kept.clear()
    _first_terms.cache_clear()
    _further_terms.cache_clear()


def first_blocks(prepared: Recordings, joint: int) -> list[Float[ndarray, "rows columns"]]:
    """Filtered columns of splines in the joint's own coordinates, and in others' positions and velocities."""
    return [_filtered(term, prepared) for term in _first_terms(prepared, joint)]


def further_blocks(prepared: Recordings, joint: int) -> list[Float[ndarray, "rows columns"]]:
    """Filtered columns of products and fine splines, of friction at low speed and in each recording."""
    own = [_own_friction(prepared, joint)] if len(prepared) > 1 else []
    return [*(_filtered(term, prepared) for term in _further_terms(prepared, joint)), *own]


@lru_cache(maxsize=REMEMBERED)
def _first_terms(prepared: Recordings, joint: int) -> tuple[SmoothTerm, ...]:
    terms = [
        SmoothTerm(joint, (coordinate(prepared, "dq", joint, 10),)),
        SmoothTerm(joint, (coordinate(prepared, "q", joint, 10),)),
        SmoothTerm(joint, (coordinate(prepared, "q", joint, 6),), direction=joint),
        SmoothTerm(joint, (coordinate(prepared, "ddq", joint, 6),)),
    ]
    for other in range(prepared[0].torque.shape[1]):
        if other != joint:
            terms.append(SmoothTerm(joint, (coordinate(prepared, "dq", other, 5),)))
            terms.append(SmoothTerm(joint, (coordinate(prepared, "q", other, 5),)))
    return tuple(terms)


@lru_cache(maxsize=REMEMBERED)
def _further_terms(prepared: Recordings, joint: int) -> tuple[SmoothTerm, ...]:
    joints = range(prepared[0].torque.shape[1])
    fine = coordinate(prepared, "q", joint, PIECES_FINE)
    together = terms_together(prepared, len(joints), [joint])
    steady = [t for t in together if "time" not in t.depends_on]
    others = [i for i in joints if i != joint]
    turned = [SmoothTerm(joint, (coordinate(prepared, "q", i),), direction=i) for i in others]
    return (
        SmoothTerm(joint, (fine,)),
        SmoothTerm(joint, (fine,), direction=joint),
        SmoothTerm(
            joint, (coordinate(prepared, "dq", joint, PIECES_SLOW).crowded(SLOW),), direction=joint
        ),
        *(SmoothTerm(joint, (loop(prepared, i),)) for i in joints),
        *turned,
        *steady,
    )


def _filtered(term: SmoothTerm, prepared: Recordings) -> Float[ndarray, "rows columns"]:
    """The columns of a term, kept as far as the bytes reach."""
    key = prepared, (term.coordinates, term.direction)
    if key in _kept:
        return _kept[key]
    if any(recordings != prepared for recordings, _ in _kept):
        _kept.clear()
    turned = term.direction
    width = 0.0 if turned is None else float(_sign_widths(prepared)[turned])
    found = np.concatenate(
        [p.band.apply(effect_columns(term, p.motion, width)[term.joint]) for p in prepared]
    )
    if found.nbytes + sum(columns.nbytes for columns in _kept.values()) <= KEPT_BYTES:
        _kept[key] = found
    return found


def _sign_widths(prepared: Sequence[Prepared]) -> Float[ndarray, " joints"]:
    """Velocities over which the sign of each joint's motion turns [rad/s]."""
    return np.maximum(WIDTH_PER_SIGMA * prepared[0].sign_noise, LEAST_WIDTH)


def _own_friction(
    prepared: Sequence[Prepared], joint: int
) -> Float[ndarray, "rows recordings_twice"]:
    """Filtered columns of dry and viscous friction that each recording has of its own."""
    width, blocks = float(_sign_widths(prepared)[joint]), []
    for p in prepared:
        speed = p.motion.dq[:, joint]
        blocks.append(p.band.apply(np.stack([np.tanh(speed / width), speed], axis=1)))
    return np.asarray(block_diag(*blocks))


def model_columns(
    fit: LinearFit, prepared: Sequence[Prepared]
) -> Float[ndarray, "rows joints columns"]:
    """Filtered columns that a model brings to each joint of a rich fit.

    Its own; the rate of its torque, which a delay would leave; and that torque's size with the
    direction.
    """
    widths = _sign_widths(prepared)
    full, blocks = fit.full_parameters(), []
    for p in prepared:
        columns = fit.model.columns(p.motion)
        torque = columns @ full
        rate = np.gradient(torque, 1 / p.band.rate, axis=0)
        loaded = np.abs(torque) * np.tanh(p.motion.dq / widths)
        further = np.stack([rate, loaded], axis=2)
        blocks.append(p.band.apply(np.concatenate([columns[:, :, fit.columns], further], axis=2)))
    return np.concatenate(blocks)
