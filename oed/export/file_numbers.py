"""Which numbers a model.json can hold."""

from __future__ import annotations

from oed.export.model_record import ModelFileError

# Powers and quotients of two such numbers still are numbers. Nothing of an arm comes near, in any unit,
# nor what rounding leaves of one, 1e-16, or its cube.
LEAST = 1e-100
MOST = 1e100


def check_numbers(plain: object, place: str) -> None:
    """Refuse numbers that arithmetic makes infinite or zero.

    Args:
        plain: Value of JSON.
        place: Where in the file it stands, for the message.

    Raises:
        ModelFileError: Naming the place.
    """
    if isinstance(plain, dict):
        for key, value in plain.items():
            check_numbers(value, f"{place}.{key}")
    elif isinstance(plain, list):
        for number, value in enumerate(plain):
            check_numbers(value, f"{place}[{number}]")
    elif isinstance(plain, int | float) and plain and not LEAST <= abs(plain) <= MOST:
        shown = f"{plain:g}" if isinstance(plain, float) else f"of {plain.bit_length()} bits"
        raise ModelFileError(
            f"{place}: a number {shown} is beyond what can be computed with: its size must be zero, "
            f"or from {LEAST:g} to {MOST:g}"
        )
