"""The options of a configuration, as help and the reference show them."""

from __future__ import annotations

import dataclasses
import inspect
import re
from functools import partial
from typing import Annotated, Any, get_type_hints

import tyro
from tyro.constructors import (
    ConstructorRegistry,
    StructConstructorSpec,
    StructFieldSpec,
    StructTypeInfo,
)

ENTRY = re.compile(r"^ {4}(\w+): ", re.MULTILINE)


@dataclasses.dataclass(frozen=True)
class Option:
    """One field of a configuration.

    Attributes:
        name: Of the field.
        type: Of its value, with what tyro is told of it.
        default: `tyro.MISSING_NONPROP` where the option must be given.
        meaning: From the docstring; empty where nothing is said.
    """

    name: str
    type: Any
    default: Any
    meaning: str

    @property
    def is_required(self) -> bool:
        """Whether it must be given."""
        return self.default is tyro.MISSING_NONPROP

    @property
    def is_left_out(self) -> bool:
        """Whether its default stands for nothing: not given, empty, or a switch that is off."""
        return self.default is None or self.default is False or self.default in ("", ())


def options_of(configuration: type) -> tuple[Option, ...]:
    """The options of a configuration, in the order in which help lists them.

    Args:
        configuration: A dataclass.
    """
    types = get_type_hints(configuration, include_extras=True)
    said = meanings(configuration)
    return tuple(
        Option(field.name, types[field.name], _default(field), said.get(field.name, ""))
        for field in dataclasses.fields(configuration)
        if field.init
    )


def meanings(configuration: type) -> dict[str, str]:
    """What the docstrings of a class and of those it derives from say of each attribute."""
    found: dict[str, str] = {}
    for kind in reversed(configuration.__mro__):
        text = inspect.cleandoc(kind.__dict__.get("__doc__") or "")
        _, _, attributes = text.partition("\nAttributes:\n")
        _, *parts = ENTRY.split(attributes)
        for name, meaning in zip(parts[::2], parts[1::2], strict=True):
            found[name] = " ".join(meaning.split())
    return found


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default is not dataclasses.MISSING:
        return field.default
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return tyro.MISSING_NONPROP


# By which tyro makes options of a dataclass.
REGISTRY = ConstructorRegistry()


@REGISTRY.struct_rule
def _options(info: StructTypeInfo) -> StructConstructorSpec | None:
    # A generic one is tyro's own, around what is asked for.
    if not dataclasses.is_dataclass(info.type) or hasattr(info.type, "__parameters__"):
        return None
    options = options_of(info.type)
    if dataclasses.is_dataclass(info.default):  # the settings that a nested field has
        options = tuple(
            dataclasses.replace(option, default=getattr(info.default, option.name))
            for option in options
        )
    return StructConstructorSpec(info.type, tuple(map(_field, options)))


def _field(option: Option) -> StructFieldSpec:
    hint = tyro.conf.arg(help_behavior_hint=partial(_hint, option))
    shown: Any = (
        option.type if dataclasses.is_dataclass(option.type) else Annotated[option.type, hint]
    )
    return StructFieldSpec(option.name, shown, option.default, option.meaning)


def _hint(option: Option, shown: str) -> str:
    if option.is_required:  # as several values in a row are, which tyro takes for none
        return "(required)"
    return "" if option.is_left_out else f"(default: {shown})"
