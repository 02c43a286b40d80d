"""Effects as plain values and back: what a model.json holds of each.

An effect is a frozen dataclass: its fields say all of it. A field is a number, text, None, a tuple,
an array, a robot, a reference torque, another effect, or a dataclass that the effect names in
`made_of`. Nothing here knows any effect: those of a user's own code leave and come back in the same
way, once the module that defines them is imported.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

import msgspec
import numpy as np
from numpy import ndarray

from oed.dynamics.effects import Effect, MeasurementEffect
from oed.dynamics.effects.reference import ReferenceTorque
from oed.export.model_record import ModelFileError
from oed.robot import Robot

KIND, NUMBER, ARRAY = "type", "number", "array"
ROBOT, REFERENCE = "robot", "reference"
# What JSON has no number for: a load that is held for good.
NUMBERS = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}

AnyEffect = Effect | MeasurementEffect
EffectT = TypeVar("EffectT", Effect, MeasurementEffect)


@dataclass
class FormWriter:
    """Writes the effects of one model.

    Attributes:
        robot: The model's; robots of effects differ from it in numbers alone.
        references: Each reference torque that was met, once, those it needs before it.
    """

    robot: Robot
    references: list[dict[str, Any]] = field(default_factory=list)
    _places: dict[int, int] = field(default_factory=dict)
    _kept: list[ReferenceTorque] = field(default_factory=list)

    def form(self, effect: AnyEffect) -> dict[str, Any]:
        """An effect as plain values."""
        return self._dataclass(effect.leaving)

    def _dataclass(self, value: object) -> dict[str, Any]:
        fields = dataclasses.fields(value)  # pyright: ignore[reportArgumentType]
        own = {f.name: self._plain(getattr(value, f.name), f.name) for f in fields}
        return {KIND: type(value).__name__, **own}

    def _plain(self, value: object, place: str) -> Any:
        if value is None or isinstance(value, bool | int | str):
            return value
        if isinstance(value, float):
            return float(value) if math.isfinite(value) else {NUMBER: str(float(value))}
        if isinstance(value, np.generic):
            return self._plain(value.item(), place)
        if isinstance(value, ndarray):
            return {ARRAY: self._plain(value.tolist(), place)}
        if isinstance(value, tuple | list):
            return [self._plain(item, place) for item in value]
        if isinstance(value, Robot):
            return {ROBOT: self._robot(value)}
        if isinstance(value, ReferenceTorque):
            return {REFERENCE: self._reference(value)}
        if isinstance(value, AnyEffect):
            return self.form(value)
        if dataclasses.is_dataclass(value):
            return self._dataclass(value)
        raise TypeError(f"{place} is a {type(value).__name__}, which no model file can hold")

    def _robot(self, robot: Robot) -> dict[str, list[float]]:
        """In what it differs from the model's."""
        same_joints = (
            robot.joints is self.robot.joints or robot.joint_names == self.robot.joint_names
        )
        if not same_joints:
            raise ValueError(
                f"an effect's robot {robot.name!r} is not the model's, {self.robot.name!r}"
            )
        pairs = ((x, getattr(robot, x), getattr(self.robot, x)) for x in ("parameters", "gravity"))
        return {name: own.tolist() for name, own, whole in pairs if not np.array_equal(own, whole)}

    def _reference(self, reference: ReferenceTorque) -> int:
        if id(reference) not in self._places:
            found = {
                ROBOT: self._robot(reference.robot),
                "others": [self.form(effect) for effect in reference.others],
                "coefficients": list(reference.coefficients),
            }
            if found not in self.references:
                self.references.append(found)
            self._places[id(reference)] = self.references.index(found)
            self._kept.append(reference)  # so that no other gets its identity
        return self._places[id(reference)]


@dataclass
class FormReader:
    """Reads the effects of one model.

    Attributes:
        robot: The model's.
        references: As they stand in the file.
    """

    robot: Robot
    references: list[dict[str, Any]]
    _read: list[ReferenceTorque] = field(default_factory=list)

    def __post_init__(self) -> None:
        for number, plain in enumerate(self.references):
            place = f"references[{number}]"
            try:
                others = tuple(self.effect(x, Effect, place) for x in plain["others"])
                coefficients = tuple(float(x) for x in plain["coefficients"])
                robot = self._robot(plain[ROBOT])
            except (KeyError, TypeError, ValueError) as error:
                raise ModelFileError(f"{place} is damaged: {error!r}") from error
            self._read.append(ReferenceTorque(robot, others, coefficients))

    def effect(self, form: Any, base: type[EffectT], place: str) -> EffectT:
        """The effect that plain values describe.

        Args:
            form: As `FormWriter.form` leaves it.
            base: `Effect` or `MeasurementEffect`.
            place: Where it stands, for the message.

        Raises:
            ModelFileError: If there is no such effect, or its values are not possible.
        """
        value = self._value(form, place)
        if not isinstance(value, base):
            raise ModelFileError(f"{place} is no {base.__name__}")
        return value

    def _value(self, plain: Any, place: str) -> Any:
        if isinstance(plain, list):
            return tuple(self._value(item, place) for item in plain)
        if not isinstance(plain, dict):
            return plain
        if KIND in plain:
            return self._dataclass(plain, place)
        if len(plain) == 1:
            ((tag, content),) = plain.items()
            if tag == NUMBER and content in NUMBERS:
                return NUMBERS[content]
            if tag == ARRAY:
                return _array(content, place)
            if tag == ROBOT:
                return self._robot(_of_kind(content, dict[str, list[float]], place))
            if tag == REFERENCE and isinstance(content, int) and 0 <= content < len(self._read):
                return self._read[content]
        raise ModelFileError(f"{place}: {str(plain)[:60]} is nothing that an effect is made of")

    def _dataclass(self, plain: dict[str, Any], place: str) -> Any:
        name = plain[KIND]
        kinds = known_kinds()
        if not isinstance(name, str) or name not in kinds:
            raise ModelFileError(
                f"{place}: there is no effect {name!r} here; if it is your own, import the module "
                "that defines it first"
            )
        hints = _hints(kinds[name])
        given = {
            key: _of_kind(self._value(x, f"{place}.{key}"), hints.get(key), f"{place}.{key}")
            for key, x in plain.items()
            if key != KIND
        }
        fields = {field.name for field in dataclasses.fields(kinds[name])}
        if other := sorted(given.keys() - fields):
            raise ModelFileError(
                f"{place}: {name} has no {', '.join(other)} in this version of the program: make the "
                "file again with it"
            )
        try:
            return kinds[name](**given)
        except (TypeError, ValueError) as error:
            raise ModelFileError(f"{place}: {name}: {error}") from error

    def _robot(self, plain: dict[str, list[float]]) -> Robot:
        numbers = {name: np.array(values, dtype=float) for name, values in plain.items()}
        return dataclasses.replace(self.robot, **numbers) if numbers else self.robot


def _hints(kind: type) -> dict[str, Any]:
    """Types of its fields; none where a user's own names what only a type checker imports."""
    try:
        return get_type_hints(kind)
    except NameError:
        return {}


def _of_kind(value: Any, hint: Any, place: str) -> Any:
    """A field's value, held to its type where that is made of numbers and words alone."""
    if not _is_plain(hint):
        return value
    try:
        return msgspec.convert(value, hint)
    except msgspec.ValidationError as error:
        raise ModelFileError(f"{place}: {error}") from error


def _is_plain(hint: Any) -> bool:
    """Whether a type is one of JSON's values, or made of such."""
    if get_origin(hint) is Literal or hint in (bool, int, float, str, type(None), Ellipsis):
        return True
    return bool(get_args(hint)) and all(_is_plain(inner) for inner in get_args(hint))


def _array(content: Any, place: str) -> ndarray:
    try:
        found = np.array(content)
    except ValueError as error:  # rows of different lengths
        raise ModelFileError(f"{place}: {error}") from error
    if found.dtype.kind not in "bif":
        raise ModelFileError(f"{place}: {str(content)[:60]} is no array of numbers")
    return found


def known_kinds() -> dict[str, type]:
    """All effects that are defined in this process and what they are made of, by name."""
    found: dict[str, type] = {}
    for kind in (*_below(Effect), *_below(MeasurementEffect)):
        for each in (*kind.made_of, kind):
            found.setdefault(each.__name__, each)
    return found


def _below(kind: type) -> Iterator[type]:
    for each in kind.__subclasses__():
        yield each
        yield from _below(each)
