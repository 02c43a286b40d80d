"""What a term of a diagnosis is called where people read of it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from oed.diagnosis.candidates.candidate import Candidate, NamedCandidate, SmoothCandidate
from oed.diagnosis.diagnose import Diagnosis
from oed.dynamics.effects.arguments import Factor, Loop, VaryingInertia
from oed.dynamics.effects.coordinates import Coordinate
from oed.dynamics.effects.smooth_term import SmoothTerm
from oed.report.joint_words import COORDINATES, place_words

Varying = Coordinate | Loop | VaryingInertia


@dataclass(frozen=True)
class TermWords:
    """A term in words.

    Attributes:
        place: Where it acts, such as "joint 2".
        what: What it is there, such as "friction that depends on its position", the joint's.
        curve: How a term without a name is made, such as "a free curve over q_2, 11 coefficients".
    """

    place: str
    what: str
    curve: str = ""

    @property
    def whole(self) -> str:
        """Such as "joint 2: friction that depends on its position (a free curve over q_2, ...)"."""
        return f"{self.place}: {self.here}"

    @property
    def here(self) -> str:
        """The same without the place."""
        return f"{self.what} ({self.curve})" if self.curve else self.what

    def at(self, joint: int) -> str:
        """For a line that says this joint already: the place only where it is another."""
        return self.here if self.place == place_words(joint) else self.whole

    def what_at(self, joint: int) -> str:
        """The same without how a curve is made."""
        return self.what if self.place == place_words(joint) else self.in_sentence

    @property
    def in_sentence(self) -> str:
        """Such as "friction that depends on its position (joint 2)"."""
        return f"{self.what} ({self.place})"


def term_words(candidate: Candidate) -> TermWords:
    """A candidate's place, and what it is."""
    place = place_words(candidate.joint)
    if isinstance(candidate, SmoothCandidate):
        return TermWords(place, _what(candidate.term), _curve(candidate.term))
    if not isinstance(candidate, NamedCandidate):
        return TermWords(place, candidate.label)
    # Of a pair the second is the joint that it comes from.
    pair = candidate.target if isinstance(candidate.target, tuple) else ()
    source = "".join(f" from joint {joint + 1}" for joint in pair[1:])
    return TermWords(place, candidate.entry.name + source)


def words_of_terms(found: Diagnosis) -> dict[str, TermWords]:
    """Words of all terms that a diagnosis speaks of, by their labels."""
    selected = found.selected
    terms = [*selected.views.terms]
    terms += [s.term for substitutes in selected.substitutes for s in substitutes]
    return {term.label: term_words(term.candidate) for term in terms}


def in_words(text: str, words: Mapping[str, TermWords]) -> str:
    """A sentence with words in place of the labels of terms."""
    if not words:
        return text
    # The longest first: one label can be the beginning of another.
    labels = sorted(words, key=len, reverse=True)
    pattern = "|".join(map(re.escape, labels))
    return re.sub(pattern, lambda m: words[m[0]].in_sentence, text)


def _what(term: SmoothTerm) -> str:
    """Kind of torque, and on what it depends."""
    own = term.joint
    varying = [c for c in term.coordinates if not isinstance(c, Factor)]
    factors = [c for c in term.coordinates if isinstance(c, Factor)]
    on = _phrases(varying, own)
    if any(isinstance(c, VaryingInertia) for c in varying):
        return f"inertia that varies with {on}"
    if [(c.kind, c.joint) for c in factors] == [("dq", own)]:
        return f"viscous friction that varies with {on}"
    if factors:
        by = " and ".join(f"the {COORDINATES[c.kind][0]} of joint {c.joint + 1}" for c in factors)
        return f"torque proportional to {by}, by a factor that varies with {on}"
    if term.direction == own:
        return f"friction that depends on {on}"
    if term.direction is not None:
        return f"torque that turns with the direction of joint {term.direction + 1} and depends on {on}"
    return f"torque that depends on {on}"


def _phrases(varying: Sequence[Varying], own: int) -> str:
    """Such as "its position and velocity and the position of joint 1"; the joint's own first."""
    by_joint: dict[int | None, list[str]] = {}
    for c in varying:
        joint, quantity = _quantity(c)
        by_joint.setdefault(joint, []).append(quantity)
    phrases = []
    for joint in sorted(by_joint, key=lambda j: (j != own, j is None, j or 0)):
        quantities = " and ".join(by_joint[joint])
        if joint is None:
            phrases.append(quantities)
        else:
            at = f"the {quantities} of joint {joint + 1}"
            phrases.append(f"its {quantities}" if joint == own else at)
    return " and ".join(phrases)


def _quantity(argument: Varying) -> tuple[int | None, str]:
    """Joint and quantity of what a curve runs over; no joint of time."""
    if isinstance(argument, Loop):
        return argument.joint, "last reversals (hysteresis)"
    if isinstance(argument, VaryingInertia):
        return _quantity(argument.position)
    if argument.kind == "time":
        return None, "time"
    return argument.joint, COORDINATES[argument.kind][0]


def _curve(term: SmoothTerm) -> str:
    """How free it is: over what, and by how many coefficients."""
    over = [_symbol(c) for c in term.coordinates if not isinstance(c, Factor)]
    count = int(np.prod([c.functions for c in term.coordinates]))
    kind = "curve" if len(over) == 1 else "surface"
    return f"a free {kind} over {' and '.join(over)}, {count} coefficients"


def _symbol(argument: Varying) -> str:
    if isinstance(argument, Loop):
        return f"loops of q_{argument.joint + 1}"
    if isinstance(argument, VaryingInertia):
        return argument.position.name
    return argument.name
