"""Fast base regressor at many instants, with its reverse-mode product.

The regressor of one instant is an expression; its nonzero entries and the product of a
gradient by them with their derivatives are evaluated at N instants at once, by machine code
where there is a C compiler and by CasADi's virtual machine where there is none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi
import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.effects import State
from oed.dynamics.motion import Motion
from oed.dynamics.native import native_function
from oed.dynamics.scalars import Scalar
from oed.dynamics.torque_model import TorqueModel

# Stands for a sign width of zero: v / SHARPEST overflows to the exact sign, and 0 stays 0.
SHARPEST = 1e-300

# (inputs, N) -> (outputs, N), both with one row a scalar
Batch = Callable[[Float[ndarray, "inputs samples"]], Float[ndarray, "outputs samples"]]


@dataclass(frozen=True)
class SoftState(State):
    """A state whose smoothing of the velocity sign is itself an input of the expression.

    Attributes:
        symbolic_width: That input [rad/s].
    """

    symbolic_width: Scalar = 0.0

    def sign(self, velocity: Scalar, width: float = 0.0) -> Scalar:
        """tanh(v / widest); the exact sign where both widths are zero."""
        return casadi.tanh(velocity / casadi.fmax(max(width, SHARPEST), self.symbolic_width))


@dataclass(frozen=True)
class CompiledRegressor:
    """Structurally nonzero entries of the base regressor, and their reverse-mode product.

    Entries are sorted by joint, then column.

    Attributes:
        joints: Number of joints n.
        columns: Number of base columns b.
        entry_joint: (nnz,) joint of each entry.
        entry_column: (nnz,) base column of each entry.
        is_native: Whether machine code runs, not the virtual machine.
    """

    joints: int
    columns: int
    entry_joint: Int[ndarray, " entries"]
    entry_column: Int[ndarray, " entries"]
    is_native: bool
    _forward: Batch
    _reverse: Batch

    def entries(self, motion: Motion, sign_width: float = 0.0) -> Float[ndarray, "entries samples"]:
        """Torque per unit parameter, the nonzero entries at every instant.

        Args:
            motion: N instants.
            sign_width: Smoothing of the velocity sign [rad/s]; 0 for the exact sign.
        """
        return self._forward(_inputs(motion, sign_width))

    def pull_back(
        self,
        motion: Motion,
        adjoint: Float[ndarray, "entries samples"],
        sign_width: float = 0.0,
    ) -> tuple[Float[ndarray, "samples joints"], ...]:
        """Gradients by q, dq and ddq of a function whose gradient by `entries` is `adjoint`."""
        gradients = self._reverse(np.concatenate([_inputs(motion, sign_width), adjoint]))
        return tuple(part.T for part in np.split(gradients, 3))

    def dense(
        self, entries: Float[ndarray, "entries samples"]
    ) -> Float[ndarray, "samples joints columns"]:
        """The entries at their places among zeros."""
        result = np.zeros((entries.shape[1], self.joints, self.columns))
        result[:, self.entry_joint, self.entry_column] = entries.T
        return result

    def of_joint(self, joint: int) -> slice:
        """Which entries belong to a joint."""
        first, last = np.searchsorted(self.entry_joint, [joint, joint + 1])
        return slice(int(first), int(last))


def compile_regressor(
    model: TorqueModel, base: BaseParameters, *, native: bool = True
) -> CompiledRegressor:
    """Build the fast regressor of a model's base parameters.

    Args:
        model: Its measurement effects are not seen: they act on whole signals.
        base: Which columns.
        native: Whether to compile to machine code if there is a compiler.
    """
    return compile_columns(model, base.columns, native=native)


def compile_columns(
    model: TorqueModel, columns: Int[ndarray, " columns"], *, native: bool = True
) -> CompiledRegressor:
    """Build the fast regressor of any columns of a model.

    Args:
        model: As above, and so is `native`.
        columns: Which of its parameters, in this order.
        native: Whether to compile.
    """
    n = model.robot.n
    x = casadi.SX.sym("x", 3 * n)
    width = casadi.SX.sym("width")
    parts = casadi.vertsplit(x)
    state = SoftState(0.0, parts[:n], parts[n : 2 * n], parts[2 * n :], symbolic_width=width)
    every = [entry for effect in model.effects for entry in effect.entries(state)]
    found = [
        (joint, column, casadi.SX(entry))
        for column, kept in enumerate(columns)
        for joint, entry in every[kept].items()
        if not (casadi.SX(entry).is_zero())
    ]
    found.sort(key=lambda item: item[:2])
    values = casadi.vertcat(*(entry for _, _, entry in found))
    seeds = casadi.SX.sym("seed", len(found))
    forward = casadi.Function("forward", [casadi.vertcat(x, width)], [values])
    product = casadi.jtimes(values, x, seeds, True)
    reverse = casadi.Function("reverse", [casadi.vertcat(x, width, seeds)], [product])
    batches = native_function([forward, reverse]) if native else None
    interpreted = batches is None
    forward_batch, reverse_batch = batches or (_interpreted(forward), _interpreted(reverse))
    return CompiledRegressor(
        joints=n,
        columns=len(columns),
        entry_joint=np.array([joint for joint, _, _ in found]),
        entry_column=np.array([column for _, column, _ in found]),
        is_native=not interpreted,
        _forward=forward_batch,
        _reverse=reverse_batch,
    )


def _inputs(motion: Motion, sign_width: float) -> Float[ndarray, "inputs samples"]:
    width = np.full((1, len(motion)), sign_width)
    return np.concatenate([motion.q.T, motion.dq.T, motion.ddq.T, width])


def _interpreted(function: casadi.Function) -> Batch:
    def evaluate(inputs: Float[ndarray, "inputs samples"]) -> Float[ndarray, "outputs samples"]:
        return np.asarray(function(inputs))

    return evaluate
