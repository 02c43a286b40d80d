"""How the name of a column is spelled, before its words are read.

Accents, Greek letters, signs of a system's variables and of quotation, and words that are written as
one tell nothing: $TORQUE_AXIS_ACT[1], "q{1}", tau:1, Posición 1 and Istposition 1 are names as others.
"""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

from oed.experiment.importing.name_words import SOURCES
from oed.experiment.importing.quantity_names import (
    ACCELERATIONS,
    OF_JOINTS,
    POSITIONS,
    TEMPERATURES,
    TORQUES,
    VELOCITIES,
)

SIGNS = re.compile(r"[$'\"`<>{}\\#:;,@&*!?|~^=]+")
IN_BRACKETS = re.compile(r"(\[[^\[\]]*\]|\([^()]*\))")
DERIVATIVE = {"\u0307": "_dot", "\u0308": "_ddot"}  # a dot above, and two
ALPHABET = {"θ": "theta", "τ": "tau", "ω": "omega", "α": "alpha", "φ": "phi"}
# Capitals begin words, as in actualPosition, axisQMsr and joint1Pos; dQ1 is one word.
HUMP = re.compile(r"(?<=[a-z0-9])(?=[A-Z][a-z])|(?<=[a-z]{2})(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z]{2})")
LETTERS = re.compile(r"[^\W\d_]+")
# Words that say no more than that values follow, as Simulink's tau.signals.values, or Istwert.
CARRIERS = ("value", "values", "data", "signals", "wert", "werte")
CARRIER = re.compile(rf"[._ ](?:{'|'.join(CARRIERS)})(?=[\[(]|[._ ]*\d*$)", re.IGNORECASE)
QUANTITIES = frozenset({
    *(*POSITIONS, *VELOCITIES, *ACCELERATIONS, *TEMPERATURES),
    *(stem for stems in TORQUES.values() for stem in stems),
})  # fmt: skip
# Two words that are written as one: of what or by whom, and then what; its name has so many letters.
FIRST = frozenset({*OF_JOINTS, *(word for words in SOURCES.values() for word in words)})
SECOND = frozenset({*(stem for stem in QUANTITIES if len(stem) >= 3), *CARRIERS})
REMEMBERED = 10_000  # names: more than a log has


@lru_cache(maxsize=REMEMBERED)
def plainly(name: str) -> str:
    """The name in Latin letters without accents, and without signs that are no part of a word."""
    inner = name.strip().strip("'\"")
    if inner.startswith("(") and inner.endswith(")") and "(" not in inner[1:]:
        inner = inner[1:-1]
    parts = IN_BRACKETS.split(_latin(inner))
    # What stands in brackets is of which element, or a unit that is not known.
    parts = [
        part.replace(":,", "") if i % 2 else SIGNS.sub("_", part) for i, part in enumerate(parts)
    ]
    return re.sub("_{2,}", "_", "".join(parts)).strip("_% ")


def parted(name: str) -> str:
    """The name with its words apart where only a capital begins one, or where two are written as one."""
    return LETTERS.sub(lambda word: _two_words(word[0]), HUMP.sub("_", name))


def without_carriers(name: str) -> str:
    """The name without words behind it that say no more than that values follow."""
    while (shorter := CARRIER.sub("", name)) != name:
        name = shorter
    return name


def _latin(name: str) -> str:
    found = ""
    for letter in unicodedata.normalize("NFKD", name):
        if letter == "\u0307" or (letter == "\u0308" and found.endswith(("q", *ALPHABET.values()))):
            found += DERIVATIVE[letter]
        elif not unicodedata.combining(letter):
            found += ALPHABET.get(letter, letter)
    return found


@lru_cache(maxsize=REMEMBERED)
def _two_words(word: str) -> str:
    """Jointpos as Joint_pos, Istwinkel as Ist_winkel: of what or by whom, and then what."""
    lower = word.lower()
    if lower in QUANTITIES:
        return word
    cuts = (i for i in range(1, len(word)) if lower[:i] in FIRST and lower[i:] in SECOND)
    cut = next(cuts, 0)
    return f"{word[:cut]}_{word[cut:]}" if cut else word
