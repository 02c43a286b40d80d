"""What a user states as KEY=VALUE."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oed.experiment.log_format import COLUMN_KEYS, UNIT_KEYS

# By key of dataset.toml: what states it.
OPTIONS = {
    "sign": "--sign",
    "zero": "--zero",
    "gravity": "--gravity",
    "drive.current_to_torque": "--current-to-torque",
    **{f"columns.{key}": f"--columns {key}=" for key in COLUMN_KEYS},
    **{f"units.{key}": f"--units {key}=" for key in UNIT_KEYS},
}


def stated_words(option: str, given: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Words by key, from items such as "q=a,b"; a key without words has none.

    Raises:
        ValueError: If an item has no key, or a key is given twice, naming the option.
    """
    found: dict[str, tuple[str, ...]] = {}
    for item in given:
        key, equals, value = item.partition("=")
        if not equals or not key:
            raise ValueError(f"{option} {item!r}: write KEY=VALUE, as in q=a,b")
        if key in found:
            raise ValueError(f"{option} {item!r}: {key} is given twice")
        found[key] = tuple(word.strip() for word in value.split(",") if word.strip())
    return found


def stated_numbers(option: str, given: Sequence[str]) -> dict[str, float]:
    """One number by key, from items such as "finger=0.04".

    Raises:
        ValueError: As `stated_words`, or if a value is no number.
    """
    found = {}
    for key, words in stated_words(option, given).items():
        try:
            (found[key],) = map(float, words)
        except ValueError:
            raise ValueError(f"{option} {key}: write one number, as in {key}=0.04") from None
    return found


def check_keys(option: str, given: Mapping[str, object] | None, known: Sequence[str]) -> None:
    """Refuse keys that nothing reads.

    Raises:
        ValueError: Naming the option.
    """
    for key in given or {}:
        if key not in known:
            raise ValueError(f"{option} {key}=: nothing is called so; known are {', '.join(known)}")
