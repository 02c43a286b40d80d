"""Which smooth terms compete, and over what range of their coordinates."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from oed.dynamics.effects.arguments import Factor, Loop, VaryingInertia
from oed.dynamics.effects.coordinates import Coordinate
from oed.dynamics.effects.smooth_term import SmoothTerm
from oed.dynamics.effects.thermal import since
from oed.experiment.preparation.prepared import Prepared

PIECES_ALONE = 8
PIECES_FINE = 36  # what repeats along a turn: teeth, poles, balls
PIECES_TOGETHER = 4
ALL_PAIRED = 3  # joints up to which any two coordinates make a term of any joint
SLIDERS = 6
# Break-away distances over the range of motion: shorter than that is a sign, longer a spring.
DISTANCES = (0.003, 0.3)
# Range between these quantiles: a spline's end piece needs data, not one outlying sample.
QUANTILES = (0.002, 0.998)


def coordinate(
    prepared: Sequence[Prepared], kind: str, joint: int, pieces: int = PIECES_ALONE
) -> Coordinate:
    """A coordinate with the range that the recordings cover; time with that of those for estimation.

    Where an arm was it comes again, when it was it does not: a course over time ends with what it is
    looked for in.
    """
    start = 0.0
    if kind == "time":
        # Of recordings laid end to end each one's own: what drifts does so again in the next.
        start = None if any(p.laid for p in prepared) else 0.0
        own = [p for p in prepared if p.role == "estimation"] or prepared
        times = [since(p.motion.t, start) for p in own]
        lower, upper = min(float(t[0]) for t in times), max(float(t[-1]) for t in times)
    else:
        values = np.concatenate([getattr(p.motion, kind)[:, joint] for p in prepared])
        lower, upper = (float(x) for x in np.quantile(values, QUANTILES))
    if upper - lower < 1e-6:
        upper = lower + 1e-6
    return Coordinate(kind, joint, lower, upper, pieces, start=start)


def _from_rest(prepared: Sequence[Prepared], kind: str, joint: int) -> Coordinate:
    """A speed or an acceleration as a cause of its own: without it there is no torque."""
    return dataclasses.replace(coordinate(prepared, kind, joint), from_rest=True)


def loop(prepared: Sequence[Prepared], joint: int) -> Loop:
    """Loops against a joint's position of every width that the motion shows."""
    whole = coordinate(prepared, "q", joint)
    span = whole.upper - whole.lower
    return Loop(joint, DISTANCES[0] * span, DISTANCES[1] * span, SLIDERS)


def terms_alone(prepared: Sequence[Prepared], joints: int) -> tuple[SmoothTerm, ...]:
    """Terms in one coordinate or loop, for every joint."""
    terms: list[SmoothTerm] = []
    for j in range(joints):
        for i in range(joints):
            terms.append(SmoothTerm(j, (coordinate(prepared, "q", i),)))
            terms.append(SmoothTerm(j, (_from_rest(prepared, "dq", i),)))
            terms.append(SmoothTerm(j, (loop(prepared, i),)))
            # Friction of this joint that varies, and what another joint drags along.
            own = {i, j}
            terms += [SmoothTerm(j, (coordinate(prepared, "q", i),), direction=k) for k in own]
            # Drag and inertia that a position changes.
            terms.append(SmoothTerm(j, (coordinate(prepared, "q", i), Factor("dq", j))))
            if i == j:
                terms.append(SmoothTerm(j, (VaryingInertia(coordinate(prepared, "q", j)),)))
            else:
                terms.append(SmoothTerm(j, (coordinate(prepared, "q", i), Factor("ddq", j))))
                terms.append(SmoothTerm(j, (coordinate(prepared, "dq", i),), direction=j))
                terms.append(SmoothTerm(j, (coordinate(prepared, "q", j), Factor("dq", i))))
        fine = coordinate(prepared, "q", j, PIECES_FINE)
        terms += [SmoothTerm(j, (fine,)), SmoothTerm(j, (fine,), direction=j)]
        terms.append(SmoothTerm(j, (_from_rest(prepared, "ddq", j),)))
        # Contacts take time: friction of a joint that gathers speed is another.
        terms.append(SmoothTerm(j, (_from_rest(prepared, "ddq", j),), direction=j))
        terms.append(SmoothTerm(j, (coordinate(prepared, "time", 0),)))
        # Friction and whatever hangs on position that come and go.
        terms.append(SmoothTerm(j, (coordinate(prepared, "time", 0),), direction=j))
    return tuple(terms)


def terms_together(
    prepared: Sequence[Prepared], joints: int, acting: Sequence[int]
) -> tuple[SmoothTerm, ...]:
    """Terms in two coordinates for the joints where something is left."""
    terms: list[SmoothTerm] = []
    kinds = [(kind, i) for i in range(joints) for kind in ("q", "dq")]
    time = coordinate(prepared, "time", 0, PIECES_TOGETHER)
    ranged = {c: coordinate(prepared, *c, PIECES_TOGETHER) for c in kinds}
    for j in acting:
        # With many joints only pairs that hold a coordinate of the joint itself: the number of
        # all pairs grows with the square, and so does the multiplicity.
        near = set(kinds) if joints <= ALL_PAIRED else {("q", j), ("dq", j)}
        terms += [
            SmoothTerm(j, (ranged[one], ranged[other]))
            for one, other in combinations(kinds, 2)
            if near & {one, other}
        ]
        # What changes with time: friction, and what pulls at a position.
        changing = [("dq", j), *(c for c in kinds if c[0] == "q" and c in near)]
        terms += [SmoothTerm(j, (time, ranged[c])) for c in changing]
    return tuple(terms)
