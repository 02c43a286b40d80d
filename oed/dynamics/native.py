"""Machine code for CasADi functions of scalars, evaluated at many instants at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import casadi


def native_function(functions: Sequence[casadi.Function]) -> tuple[Callable, ...] | None:
    """Batch versions of the functions; None where there is no compiler."""
    return None
