"""One control period of plant, controller and observer, compiled, and the loop over it."""

from __future__ import annotations

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.array_function import array_function
from oed.dynamics.native import Batch, native_function
from oed.errors import OedError
from oed.experiment.control import Controller
from oed.experiment.setup import Setup

# Keeps the quotient of the exponential step defined at rest; 1e-8 of its value there.
SLOWEST = 1e-4  # [1/s]
# Compiling takes a second or two, and is kept for the next time.
WORTH_COMPILING = 8  # [runs]


class SimulationDiverged(OedError):
    """The simulated arm ran away.

    Attributes:
        instant: When its state was first not finite [s].
    """

    def __init__(self, message: str, instant: float) -> None:
        super().__init__(message)
        self.instant = instant


def control_period(setup: Setup) -> casadi.Function:
    """One period: [state, inputs] -> [next state, q, dq, measured q, observed dq, command].

    The state is [q, dq, memory, observer]; the inputs are [t, q_d, dq_d,
    feedforward, disturbance].
    """
    plant, controller, n = setup.plant, setup.controller, setup.plant.robot.n
    x = casadi.SX.sym("x", 4 * n + plant.memory_states)
    w = casadi.SX.sym("w", 4 * n + 1)
    ends = np.cumsum([0, n, n, plant.memory_states, n, n]).tolist()
    q, dq, memory, s_1, s_2 = casadi.vertsplit(x, ends)
    t, q_d, dq_d, forward, push = casadi.vertsplit(w, np.cumsum([0, 1, n, n, n, n]).tolist())
    A, B, D = (
        casadi.DM(m.reshape(n, -1)) for m in controller.observer.discretised(controller.period)
    )
    measured = setup.sensors.encode(q)
    dq_hat = s_2 + D[:, 1] * measured
    feedback = casadi.DM(controller.stiffness) * (q_d - measured)
    feedback += casadi.DM(controller.damping) * (dq_d - dq_hat)
    command = forward + feedback
    mechanical = _integrate(setup, t, (q, dq, memory), command + push)
    next_x = casadi.vertcat(
        mechanical,
        A[:, 0] * s_1 + A[:, 1] * s_2 + B[:, 0] * measured,
        A[:, 2] * s_1 + A[:, 3] * s_2 + B[:, 1] * measured,
    )
    output = casadi.vertcat(next_x, q, dq, measured, dq_hat, command)
    return casadi.Function("period", [casadi.vertcat(x, w)], [output], {"cse": True})


def observer_at_rest(
    controller: Controller, q: Float[ndarray, " joints"]
) -> Float[ndarray, " observer"]:
    """Observer states that read q and no velocity."""
    _, _, D = controller.observer.discretised(controller.period)
    return np.concatenate([q - D[:, 0] * q, -D[:, 1] * q])


def _integrate(
    setup: Setup,
    t: casadi.SX,
    start: tuple[casadi.SX, casadi.SX, casadi.SX],
    applied: casadi.SX,
) -> casadi.SX:
    """The plant over one period under a held torque: Strang's splitting.

    Half a step of the memory, a Runge-Kutta step of the arm with the memory at rest, half a
    step of the memory. Bristles forget at a rate of speed over deflection, far too fast for
    Runge-Kutta at 1 ms; the exponential step is exact for them at constant speed.
    """
    plant, n = setup.plant, setup.plant.robot.n
    h = setup.controller.period / setup.substeps
    acceleration, memory_rates = plant.acceleration(), plant.memory_rates()
    q, dq, memory = start
    x = casadi.vertcat(q, dq)

    def remembered(time: casadi.SX, x: casadi.SX, memory: casadi.SX) -> casadi.SX:
        rate, decay = memory_rates(time, *casadi.vertsplit(x, [0, n, 2 * n]), memory)
        decay = decay - SLOWEST
        return memory + rate * (casadi.exp(decay * h / 2) - 1) / decay

    def slope(time: casadi.SX, x: casadi.SX, memory: casadi.SX) -> casadi.SX:
        q, dq = casadi.vertsplit(x, [0, n, 2 * n])
        return casadi.vertcat(dq, acceleration(time, q, dq, memory, applied))

    for step in range(setup.substeps):
        now = t + step * h
        if plant.memory_states:
            memory = remembered(now, x, memory)
        k_1 = slope(now, x, memory)
        k_2 = slope(now + h / 2, x + h / 2 * k_1, memory)
        k_3 = slope(now + h / 2, x + h / 2 * k_2, memory)
        k_4 = slope(now + h, x + h * k_3, memory)
        x = x + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
        if plant.memory_states:
            memory = remembered(now + h, x, memory)
    return casadi.vertcat(x, memory)


def run_loop(
    setup: Setup,
    initial: Float[ndarray, "states runs"],
    inputs: Float[ndarray, "samples inputs runs"],
) -> Float[ndarray, "samples outputs runs"]:
    """Run the control period over all samples, the runs side by side."""
    total, _, runs = inputs.shape
    size = len(initial)
    step = control_period(setup)
    evaluate = _batch(step, runs)
    outputs = np.empty((total, step.size1_out(0) - size, runs))
    state = initial
    for k in range(total):
        result = evaluate(np.concatenate([state, inputs[k]]))
        state = result[:size]
        outputs[k] = result[size:]
    finite = np.isfinite(outputs).all(axis=(1, 2))
    if not (finite.all() and np.isfinite(state).all()):
        instant = float(np.argmin(finite) if not finite.all() else total) * setup.controller.period
        raise SimulationDiverged(f"the simulated arm runs away after {instant:.3f} s", instant)
    return outputs


def _batch(step: casadi.Function, runs: int) -> Batch:
    """The control period for many runs at once: machine code if that pays and can be had."""
    compiled = native_function([step]) if runs >= WORTH_COMPILING else None
    if compiled is not None:
        return compiled[0]
    many = array_function(step.map(runs) if runs > 1 else step)
    return lambda values: many(values)[0]
