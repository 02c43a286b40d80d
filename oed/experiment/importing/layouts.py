"""The name of a column taken apart: which quantity it is, of which joint, in which unit."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from oed.experiment.drive import TorqueKind
from oed.experiment.importing.name_words import (
    WORD_OR_NUMBER,
    Source,
    is_of_motor,
    joint_number,
    without_source,
    without_word_of_joints,
)
from oed.experiment.importing.quantity_names import (
    JOINTS_ALONE,
    OF_MOTORS,
    OF_THE_ROBOT,
    ONLY_WITH_A_UNIT,
    TORQUES,
)
from oed.experiment.importing.spelling import QUANTITIES, parted, plainly, without_carriers
from oed.experiment.units import CURRENTS, Quantity, plain
from oed.experiment.units_in_names import marked_unit, suffixed_unit

# Columns of lists whose elements may be of several quantities, and then say so.
MIXED = "state"
ELEMENT = re.compile(r"[_ -]+([^\[\]./]+)\[(\d+)\]")  # of a list whose name has more words
BETWEEN_WORDS = re.compile("[_ -]+")
MOTOR_BEHIND = re.compile(rf"(?<=[^._/ ])[._/ ]+({'|'.join(OF_MOTORS)})$", re.IGNORECASE)
# Sources of what was measured, the likelier first. Raw may be numbers of a converter, which a plain
# name beside it is not; what was filtered lags behind the rest of the log.
MEASURED: tuple[Source, ...] = ("measured", "", "raw", "filtered")
REMEMBERED = 10_000  # names, each for a quantity: more than a log has


@dataclass(frozen=True)
class Named:
    """A column's name taken apart.

    Attributes:
        column: The name in the log.
        stem: What is logged, in lower case.
        label: Of which joint, "" if it is of none.
        unit: Stated in the name; "" if none is.
        source: Whether the name says that it was measured or commanded.
        words: By which it does so, and those that say that it is of the joints.
        whose: Words before the quantity that are none of these, such as of which arm.
        is_plain: Whether none but those of folders stand before it.
    """

    column: str
    stem: str
    label: str
    unit: str
    source: Source = ""
    words: tuple[str, ...] = ()
    whose: frozenset[str] = frozenset()
    is_plain: bool = True


def columns_of(
    columns: Mapping[str, str],
    stems: Sequence[str],
    quantity: Quantity,
    sources: Sequence[Source] = MEASURED,
) -> list[list[Named]]:
    """Columns of a quantity, those of one stem and source together.

    Plain names go before others, those of the joints before those of the motors that turn them, and
    torques before currents.

    Args:
        columns: What each column is called, by its name.
        stems: Names of the quantity.
        quantity: Whose units a name may state.
        sources: That count.

    Returns:
        In the order of the sources, and for each in that of the stems.
    """
    found: dict[tuple[bool, bool, bool, int, int, tuple[str, ...]], list[Named]] = {}
    for i, stem in enumerate(stems):
        for column, called in columns.items():
            one = _take_apart(column, called, stem, quantity)
            if one is not None and one.source in sources:
                own = rf"(?<![^\W_]){re.escape(stem)}(?![^\W\d_])"
                others = re.sub(own, "", _spelled(parted(plainly(called))))
                rank = is_of_motor(others), plain(one.unit) in CURRENTS
                key = (not one.is_plain, *rank, sources.index(one.source), i, one.words)
                found.setdefault(key, []).append(one)
    return [found[key] for key in sorted(found, key=lambda key: key[:5])]


def torques_of(columns: Mapping[str, str], kind: TorqueKind) -> list[list[Named]]:
    """Columns of what stands for torque, as `columns_of`."""
    if kind != "commanded":
        return columns_of(columns, TORQUES[kind], "tau")
    said = columns_of(columns, TORQUES["measured"], "tau", ("commanded",))
    return said + columns_of(columns, TORQUES[kind], "tau", ("commanded", ""))


def _take_apart(column: str, called: str, stem: str, quantity: Quantity) -> Named | None:
    for bare, unit, source, words in _readings(called, quantity):
        found = _label(bare, stem) if stem in _spelled(bare) else None
        if found is None or _contradicts(called, unit, stem, quantity):
            continue
        label, of_joints, around = found
        if stem in JOINTS_ALONE and not _are_joints_alone(bare, label, around):
            continue
        own = re.split("[./]", around)[-1]
        said = (*words, *of_joints)
        return Named(column, stem, label, unit, source, said, whose(around), not own)
    return None


def _contradicts(called: str, unit: str, stem: str, quantity: Quantity) -> bool:
    """Whether what a name ends with is no unit after all, as in tau_a, or lacks where it must be."""
    if not unit:
        return stem in ONLY_WITH_A_UNIT or (stem in JOINTS_ALONE and quantity != "q")
    is_marked = bool(marked_unit(called, "tau")[1])
    return plain(unit) in CURRENTS and stem not in TORQUES["current"] and not is_marked


def _are_joints_alone(bare: str, label: str, around: str) -> bool:
    """Whether a name is no more than that of a joint, by its number."""
    return not _quantities(bare) and not whose(around) and joint_number(label) is not None


def _quantities(name: str) -> frozenset[str]:
    """Words of a name that tell a quantity."""
    words = (word.lower() for word in WORD_OR_NUMBER.findall(parted(name)))
    return QUANTITIES.intersection(words) - {*JOINTS_ALONE, MIXED}


@lru_cache(maxsize=REMEMBERED)
def _readings(
    called: str, quantity: Quantity
) -> tuple[tuple[str, str, Source, tuple[str, ...]], ...]:
    """Ways to read a name, which all stems share: what is left of it, its unit, its source and words of that."""
    return tuple(
        (bare, unit, source, words)
        for name, unit in _with_units(called, quantity)
        for spelling in dict.fromkeys((plainly(name), parted(plainly(name))))
        for bare, source, words in (without_source(without_carriers(spelling)),)
    )


def _with_units(called: str, quantity: Quantity) -> list[tuple[str, str]]:
    """The name without the unit that it may end with, and with no unit."""
    called = called.strip().strip("'\"")
    ways = (suffixed_unit(called, quantity), marked_unit(called, quantity))
    return [*((name, unit) for name, unit in ways if unit), (called, "")]


def whose(name: str) -> frozenset[str]:
    """Words of a name that tell neither a quantity nor who says it nor that it is of the joints."""
    bare = without_source(without_carriers(parted(plainly(name))))[0]
    words = (word.lower() for word in WORD_OR_NUMBER.findall(bare))
    return frozenset(word for word in words if word not in OF_THE_ROBOT)


def _label(name: str, stem: str) -> tuple[str, tuple[str, ...], str] | None:
    """Whose a column with this stem is, the words of joints before it, and all else around it.

    None if it has another stem. What stands around it are its folders, which are those of HDF5
    groups, structs and topics and end with a point, and words of its own name, as in left_q_1 and
    q_left[1].
    """
    words: tuple[str, ...] = ()
    rest: str | None = name
    while rest is not None:
        label = _label_behind(rest, stem)
        if label is not None:
            return label, words, ""
        element = ELEMENT.fullmatch(_spelled(rest)[len(stem) :])
        if element is not None and _spelled(rest).startswith(stem) and not _quantities(element[1]):
            return element[2], words, element[1]
        word, rest = without_word_of_joints(rest)
        words = (*words, word)
    if _spelled(name).endswith(stem) and name[: -len(stem)][-1] in "._/ ":
        label = name[: -len(stem)].strip("._/ ")
        of_motor = MOTOR_BEHIND.search(label)
        return (
            (label[: of_motor.start()], (of_motor[1].lower(),), "") if of_motor else (label, (), "")
        )
    folder, _, inner = name.replace("/", ".").partition(".")
    found = _label(inner, stem) if inner else None
    if found is not None:
        return (*found[:2], f"{folder}.{found[2]}")
    for gap in BETWEEN_WORDS.finditer(name):
        label = _label_behind(name[gap.end() :], stem)
        if label:
            return label, (), name[: gap.start()]
    return None


def _label_behind(name: str, stem: str) -> str | None:
    """What stands behind a stem that a name begins with."""
    lower = _spelled(name)
    bracket = re.fullmatch(r"(.*?)\[(.+)\]", name)
    if bracket is not None:
        return _label_of_element(_spelled(bracket[1]).rstrip("_"), bracket[2], stem)
    if lower == stem:
        return ""
    if lower.startswith(stem):
        rest = name[len(stem) :]
        if rest.isdigit():
            return rest
        if rest[0] in "._/ (" and rest.strip("._/ ()"):
            return rest.strip("._/ ()")
    return None


def _spelled(name: str) -> str:
    """A name as stems are spelled, letter for letter."""
    return name.lower().replace(" ", "_")


def _label_of_element(owner: str, element: str, stem: str) -> str | None:
    """Whose an element of a column of lists is, such as "elbow.pos" of LeRobot's state."""
    said = re.fullmatch(r"(.+)[._](pos|position|vel|velocity|effort|torque|current)", element)
    label = element if said is None else said[1]
    if owner == MIXED and said is not None and said[2] not in ("pos", "position"):
        return label if said[2] == stem else None
    return label if owner == stem else None
