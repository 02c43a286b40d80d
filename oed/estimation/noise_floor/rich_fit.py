"""What noise there is without repetitions: what even a rich smooth fit of a joint leaves.

Splines in every coordinate by itself come first. Products of two coordinates, fine splines along a
turn, and friction that falls from rest or is another in each recording join only where they
explain far more than correlated noise would give them: every further function also follows some
noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.linalg import block_diag

from oed.dynamics.effects.smooth_term import SmoothTerm
from oed.dynamics.velocity_sign import WIDTH_PER_SIGMA
from oed.estimation.noise_floor.colour import Colour, Stretches
from oed.estimation.noise_floor.linear_fit import LinearFit, effect_columns
from oed.estimation.noise_floor.smooth_terms import PIECES_FINE, coordinate, loop, terms_together
from oed.experiment.preparation.prepared import Prepared

ROWS_PER_FREE_COLUMN = 8  # least rows for each column of the first fit
LEAST_ROWS_PER_COLUMN = 4  # and after the enrichment
# Least ratio of what a column of a further term explains to what one of correlated noise would.
CONVINCING = 3.0
MOST_FURTHER = 4
# Pieces that crowd about this share of a joint's largest speed: friction falls from rest.
PIECES_SLOW, SLOW = 12, 0.01
LEAST_WIDTH = 1e-9  # [rad/s] of a sign, where encoders have no noise
NEW = 1e-9  # squared share of a unit column outside a span, below which it adds nothing to it
REMEMBERED = 16  # joints whose first columns are kept
KEPT_BYTES = 256_000_000  # of further columns; those of more joints are worked out at each fit


@dataclass(frozen=True)
class RichFit:
    """A rich fit of one joint.

    Attributes:
        residual: (R,) what it leaves, one recording after another; zero in rows that were
            not fitted [N m].
        rank: Columns that the data determine.
        colour: Of the noise that was there.
    """

    residual: Float[ndarray, " rows"]
    rank: int
    colour: Colour


def rich_fit(
    fit: LinearFit,
    prepared: Sequence[Prepared],
    joint: int,
    *,
    own: Float[ndarray, "rows columns"],
    torque: Float[ndarray, " rows"],
    trusted: Bool[ndarray, " rows"],
    enriched: bool = True,
) -> RichFit:
    """Fit base columns and smooth terms to one joint's torque.

    Args:
        fit: Of the base model.
        prepared: The recordings.
        joint: Index.
        own: Filtered columns of the joint that its model brings.
        torque: Of the rows, less what is known to come from elsewhere [N m].
        trusted: Rows where the direction of motion is certain; the others are not fitted.
        enriched: Whether products and fine splines may join.
    """
    rows = int(trusted.sum())
    stretches = Stretches((0, *np.cumsum([p.rows for p in prepared]).tolist()), trusted)
    most = max(10, rows // ROWS_PER_FREE_COLUMN - len(fit.columns) // fit.model.robot.n)
    first = list(_first(tuple(prepared), joint))
    while len(first) > 1 and sum(block.shape[1] for block in first) > most:
        first.pop()
    span = _basis(np.concatenate([own, *first], axis=1)[trusted], np.zeros((rows, 0)))
    left = torque[trusted] - span @ (span.T @ torque[trusted])
    taken = stretches.taken_by(span)
    further = _further(tuple(prepared), joint) if enriched else ()
    tried = [_basis(block[trusted], span) for block in further]
    for _ in range(MOST_FURTHER if enriched else 0):
        shares = [_sum(taken, stretches.taken_by(basis)) for basis in tried]
        pairs = zip(tried, shares, strict=True)
        ratios = [_convincing(left, basis, taken, both, stretches) for basis, both in pairs]
        best = int(np.argmax(ratios))
        if (
            ratios[best] < CONVINCING
            or span.shape[1] + tried[best].shape[1] > rows // LEAST_ROWS_PER_COLUMN
        ):
            break
        taken, new = shares[best], tried.pop(best)
        left = left - new @ (new.T @ left)
        span = np.concatenate([span, new], axis=1)
        tried = [_basis(basis, new) for basis in tried]
    return RichFit(stretches.whole(left), span.shape[1], Colour.of(left, taken, stretches))


def lay_out(prepared: Sequence[Prepared]) -> None:
    """Work out what all rich fits of some recordings share, for processes that fork to have it."""
    for joint in range(prepared[0].torque.shape[1]):
        _first(tuple(prepared), joint)
        _further(tuple(prepared), joint)


def forget() -> None:
    """Give back what rich fits of a data set share: columns of all rows."""
    _first.cache_clear()
    _kept.clear()


def _basis(
    columns: Float[ndarray, "rows columns"], span: Float[ndarray, "rows rank"]
) -> Float[ndarray, "rows new"]:
    """Orthonormal basis of what columns add to a span."""
    norms = np.linalg.norm(columns, axis=0)
    scaled = columns / np.where(norms > 0, norms, 1.0)
    for _ in range(2):  # once more for the rounding of the first
        scaled = scaled - span @ (span.T @ scaled)
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    kept = values > NEW
    return scaled @ (vectors[:, kept] / np.sqrt(values[kept]))


def _convincing(
    before: Float[ndarray, " seen_rows"],
    basis: Float[ndarray, "seen_rows new"],
    taken: Sequence[Float[ndarray, " _"]],
    both: Sequence[Float[ndarray, " _"]],
    stretches: Stretches,
) -> float:
    """Squares that new columns explain, over those of noise of the colour that they leave.

    Args:
        before: What is left without them.
        basis: The new columns.
        taken: Share of the noise that those before take.
        both: The same with the new ones.
        stretches: Where they look.
    """
    moments = basis.T @ before
    colour = Colour.of(before - basis @ moments, both, stretches)
    own = [x - y for x, y in zip(both, taken, strict=True)]
    return float(moments @ moments) / max(colour.along(own, stretches), 1e-300)


def _sum(
    one: Sequence[Float[ndarray, " _"]], other: Sequence[Float[ndarray, " _"]]
) -> list[Float[ndarray, " _"]]:
    return [x + y for x, y in zip(one, other, strict=True)]


def _filtered(
    term: SmoothTerm, prepared: Sequence[Prepared], joint: int
) -> Float[ndarray, "rows columns"]:
    turned = term.direction
    width = 0.0 if turned is None else float(_sign_widths(prepared)[turned])
    return np.concatenate(
        [p.band.apply(effect_columns(term, p.motion, width)[joint]) for p in prepared]
    )


def _sign_widths(prepared: Sequence[Prepared]) -> Float[ndarray, " joints"]:
    """Velocities over which the sign of each joint's motion turns [rad/s]."""
    return np.maximum(WIDTH_PER_SIGMA * prepared[0].sign_noise, LEAST_WIDTH)


@lru_cache(maxsize=REMEMBERED)
def _first(
    prepared: tuple[Prepared, ...], joint: int
) -> tuple[Float[ndarray, "rows columns"], ...]:
    """Filtered columns of splines in the joint's own coordinates, and in others' positions and velocities.

    The same for every fit of a data set.
    """
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
    return tuple(_filtered(t, prepared, joint) for t in terms)


# By recordings and joint; of one set of recordings at a time.
_kept: dict[tuple[tuple[Prepared, ...], int], tuple[ndarray, ...]] = {}


def _further(
    prepared: tuple[Prepared, ...], joint: int
) -> tuple[Float[ndarray, "rows columns"], ...]:
    """The further columns of a joint, kept as far as the bytes reach."""
    key = prepared, joint
    if key in _kept:
        return _kept[key]
    if any(recordings != prepared for recordings, _ in _kept):
        _kept.clear()
    found = _further_blocks(prepared, joint)
    whole = sum(block.nbytes for blocks in (*_kept.values(), found) for block in blocks)
    if whole <= KEPT_BYTES:
        _kept[key] = found
    return found


def _further_blocks(
    prepared: tuple[Prepared, ...], joint: int
) -> tuple[Float[ndarray, "rows columns"], ...]:
    """Filtered columns of products and fine splines, of friction at low speed and in each recording.

    The same for every fit of a data set.
    """
    joints = range(prepared[0].torque.shape[1])
    fine = coordinate(prepared, "q", joint, PIECES_FINE)
    together = terms_together(prepared, len(joints), [joint])
    steady = [t for t in together if "time" not in t.depends_on]
    others = [i for i in joints if i != joint]
    turned = [SmoothTerm(joint, (coordinate(prepared, "q", i),), direction=i) for i in others]
    terms = [
        SmoothTerm(joint, (fine,)),
        SmoothTerm(joint, (fine,), direction=joint),
        SmoothTerm(
            joint, (coordinate(prepared, "dq", joint, PIECES_SLOW).crowded(SLOW),), direction=joint
        ),
        *(SmoothTerm(joint, (loop(prepared, i),)) for i in joints),
        *turned,
        *steady,
    ]
    blocks = [_filtered(t, prepared, joint) for t in terms]
    if len(prepared) > 1:
        blocks.append(_own_friction(prepared, joint))
    # In one array: the system takes a large one back as soon as it is let go.
    ends = np.cumsum([block.shape[1] for block in blocks])[:-1]
    return tuple(np.split(np.concatenate(blocks, axis=1), ends, axis=1))


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
