"""Reasons why an estimate cannot be what its name says."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects.context import Context
from oed.dynamics.effects.entry import Target

LEAST_PEAK = 1e-9  # [N m] of a joint that was predicted no torque


def joint_of(target: Target) -> int:
    """The joint that a target names.

    Raises:
        ValueError: If the target is the whole arm or a pair.
    """
    if isinstance(target, int):
        return target
    raise ValueError(f"{target=} must be the index of a joint")


def pair_of(target: Target) -> tuple[int, int]:
    """The joint and the other one that a target names.

    Raises:
        ValueError: If the target is not a pair.
    """
    if isinstance(target, tuple):
        return target
    raise ValueError(f"{target=} must be a pair of joint indices")


def peak_torque(context: Context, joint: int) -> float:
    """Largest predicted torque of a joint [N m]; above zero even where none was predicted."""
    return max(float(context.peak_torque[joint]), LEAST_PEAK)


def positive(value: float, name: str, unit: str) -> str | None:
    """A quantity that dissipates or stores energy is not negative."""
    if value > 0:
        return None
    return f"{name} is {_amount(value, unit)}: it must be positive"


def at_most(value: float, bound: float, name: str, unit: str, bound_name: str) -> str | None:
    """A quantity beyond every size that was ever reported."""
    if abs(value) <= bound:
        return None
    return f"{name} is {_amount(value, unit)}: more than {bound_name} = {_amount(bound, unit)}"


def _amount(value: float, unit: str) -> str:
    """A value with its unit, if it has one."""
    return f"{value:.3g}" if unit == "1" else f"{value:.3g} {unit}"


def share_of_coulomb(
    context: Context, joint: int, value: float, share: float, name: str
) -> str | None:
    """A friction torque far larger than the joint's Coulomb friction, where that is known."""
    coulomb = context.coulomb(joint)
    if coulomb <= 0:
        return None
    return at_most(value, share * coulomb, name, "N m", f"{share:g} times Coulomb friction")


def first_reason(reasons: Iterable[str | None]) -> str | None:
    """The first reason there is."""
    return next((reason for reason in reasons if reason is not None), None)


def finite(estimates: Float[ndarray, " columns"]) -> str | None:
    """An estimate that is no number."""
    return None if np.isfinite(estimates).all() else "an estimate is not finite"


def by_construction(
    _context: Context,
    _target: Target,
    _values: tuple[float, ...],
    estimates: Float[ndarray, " columns"],
) -> str | None:
    """A change that the shapes describe in full comes with a coefficient near one."""
    share = float(estimates[0])
    return first_reason(
        [
            positive(share, "the share of the change", "1"),
            at_most(share, 3.0, "the share of the change", "1", "3, where 1 is expected"),
        ]
    )
