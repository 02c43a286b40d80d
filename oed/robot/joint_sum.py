"""Bounds on sums of joint positions, as drives have that are coupled with one another."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

SYNTAX = "joint_2+0.5*joint_3:LOWER:UPPER"


@dataclass(frozen=True)
class JointSum:
    """A weighted sum of joint positions that stays within bounds.

    Attributes:
        factors: (n,) of each joint, 0 where it does not count.
        lower: Bound on the sum [rad or m]; -inf for none.
        upper: Likewise; inf for none.

    Raises:
        ValueError: If no joint counts, or the lower bound is not below the upper one.
    """

    factors: tuple[float, ...]
    lower: float
    upper: float

    def __post_init__(self) -> None:
        if not any(self.factors):
            raise ValueError("a sum of positions needs a joint whose factor is not zero")
        if not self.lower < self.upper:
            raise ValueError(f"a sum's lower bound {self.lower:g} is not below {self.upper:g}")

    @classmethod
    def of(
        cls,
        factors: Mapping[str, float],
        bounds: tuple[float, float],
        names: Sequence[str],
        held: Mapping[str, float],
    ) -> JointSum | None:
        """From names, where some joints may be held.

        Args:
            factors: By name of the joint.
            bounds: Lower and upper.
            names: Of the joints that move, in order.
            held: Position of others [rad or m].

        Returns:
            The sum of those that move; None where none of them is in it.

        Raises:
            ValueError: If a joint is neither, or if held ones alone break the bounds.
        """
        for name in factors:
            if name not in names and name not in held:
                raise ValueError(f"no joint {name!r} to sum; the joints: {', '.join(names)}")
        fixed = sum(f * held[name] for name, f in factors.items() if name not in names)
        lower, upper = bounds[0] - fixed, bounds[1] - fixed
        if any(factors.get(name, 0.0) for name in names):
            return cls(tuple(factors.get(name, 0.0) for name in names), lower, upper)
        if not lower <= 0.0 <= upper:
            raise ValueError(f"the sum of {', '.join(factors)}, all held, is {fixed:.4g}")
        return None

    def told(self, names: Sequence[str]) -> str:
        """As in `joint_2 - 0.5 joint_3`.

        Args:
            names: Of the joints, in order.
        """
        text = ""
        for name, factor in zip(names, self.factors, strict=True):
            if factor:
                sign = ("-" if factor < 0 else "+") if text or factor < 0 else ""
                size = "" if abs(factor) == 1.0 else f"{abs(factor):g} "
                text += f" {sign} {size}{name}" if text else f"{sign}{size}{name}"
        return text


def read_sum(text: str, names: Sequence[str]) -> tuple[dict[str, float], tuple[float, float]]:
    """Factors by name and bounds, from text such as `joint_2+0.5*joint_3:-2.8:2.8`.

    Args:
        text: Terms, then lower and upper bound.
        names: Of joints that may be named; a name may hold + or - itself.

    Raises:
        ValueError: If it is none.
    """
    terms, *bounds = text.rsplit(":", 2)
    try:
        lower, upper = (float(bound) for bound in bounds)
    except ValueError:
        raise ValueError(f"{text!r} is not {SYNTAX}") from None
    known = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))
    term = rf"([+-]?)(?:(\d+(?:\.\d*)?|\.\d+)\*)?({known})"
    packed = terms.replace(" ", "")
    if not re.fullmatch(rf"(?:{term})(?:(?=[+-]){term})*", packed):
        raise ValueError(f"{text!r} is not {SYNTAX}; the joints: {', '.join(names)}")
    factors: dict[str, float] = {}
    for sign, size, name in re.findall(term, packed):
        if name in factors:
            raise ValueError(f"{text!r} names {name!r} twice")
        factors[name] = float(sign + (size or "1"))
        if factors[name] == 0:
            raise ValueError(f"{text!r} counts {name!r} by 0; leave it out")
    return factors, (lower, upper)
