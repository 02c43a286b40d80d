"""A virtual experiment: a true plant under sampled feedback, read through real sensors.

One control period of plant, controller and observer becomes a single CasADi function, and
all repetitions run through it side by side, in machine code where there is a compiler. For
small arms that is hundreds to thousands of times faster than real time, where a Drake
Diagram with systems in Python is about as fast as real time; `oed.experiment.drake_experiment`
is the same experiment on Drake, and the tests hold the two against each other.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.dynamics.native import Batch, native_function
from oed.errors import OedError
from oed.experiment.control import Controller
from oed.experiment.disturbance import Disturbance
from oed.experiment.plant import TruePlant
from oed.experiment.recording import Recording, Role
from oed.experiment.reference import lead_in, lead_out
from oed.experiment.sensors import Sensors

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


@dataclass(frozen=True)
class Setup:
    """A laboratory: everything that stays the same from one experiment to the next.

    Attributes:
        plant: The machine as it really is.
        controller: Sampled feedback; its period is the sampling period of the recording.
        sensors: Encoder, torque signal and what is logged.
        disturbance: Random torque at the joints; None is none.
        lead_in: Time from rest to the start of the trajectory [s].
        lead_out: Time from the end of the trajectory to rest [s]; 0 to stop the log there.
        substeps: Integration steps of the plant in one control period.
    """

    plant: TruePlant
    controller: Controller
    sensors: Sensors = field(default_factory=Sensors)
    disturbance: Disturbance | None = None
    lead_in: float = 1.5
    lead_out: float = 0.0
    substeps: int = 2

    def __post_init__(self) -> None:
        if self.controller.n != self.plant.robot.n:
            raise ValueError(
                f"controller of {self.controller.n} joints, robot of {self.plant.robot.n}"
            )
        if self.lead_in <= 0 or self.substeps < 1:
            raise ValueError(f"lead-in {self.lead_in} s, {self.substeps} substeps: too small")


@dataclass(frozen=True)
class Log:
    """Raw signals of R runs, lead-in included.

    Attributes:
        t: (N, R) time [s], counted on from run to run.
        q: (N, n, R) true position.
        dq: (N, n, R) true velocity.
        measured: (N, n, R) position as the encoder reports it.
        velocity: (N, n, R) the observer's estimate.
        command: (N, n, R) torque that the controller asked for.
        lead: Samples before the trajectory proper starts.
        samples: Of the trajectory proper.
    """

    t: Float[ndarray, "samples runs"]
    q: Float[ndarray, "samples joints runs"]
    dq: Float[ndarray, "samples joints runs"]
    measured: Float[ndarray, "samples joints runs"]
    velocity: Float[ndarray, "samples joints runs"]
    command: Float[ndarray, "samples joints runs"]
    lead: int
    samples: int


def simulate(
    setup: Setup,
    reference: Motion,
    rng: np.random.Generator,
    *,
    repetitions: int = 1,
    periodic: bool = False,
    feedforward: Float[ndarray, "samples joints"] | None = None,
    name: str = "simulated",
    role: Role = "estimation",
    start: float = 0.0,
) -> Recording:
    """Run a trajectory on the virtual arm and return what a laboratory would have logged.

    Args:
        setup: The laboratory.
        reference: (N,) samples at the controller's period.
        rng: Source of disturbance and sensor noise.
        repetitions: M runs, each from rest through its own lead-in; the time between them
            is in `t`, their rows are marked in `repetition`.
        periodic: Run the M repetitions as one motion without a stop, after one lead-in and
            one period to settle; the reference is then exactly one period.
        feedforward: (N, n) torque added to the feedback [N m]; its first and last
            row hold through lead-in and lead-out.
        name: Of the recording.
        role: Of the recording.
        start: Time at which the lead-in begins [s], for effects that depend on it.

    Raises:
        ValueError: If the reference is not sampled at the controller's period.
        SimulationDiverged: If the arm runs away.
    """
    played, forward = reference, feedforward
    if periodic:
        played, forward = _tiled(reference, feedforward, repetitions + 1)
    log = run(
        setup,
        played,
        rng,
        runs=1 if periodic else repetitions,
        feedforward=forward,
        start=start,
    )
    first = log.lead + (len(reference) if periodic else 0)
    recording = read_log(setup, log, first, rng, name=name, role=role)
    if not periodic:
        return recording
    return _as_periods(recording, len(reference), setup.controller.period)


def run(
    setup: Setup,
    reference: Motion,
    rng: np.random.Generator,
    *,
    runs: int,
    feedforward: Float[ndarray, "samples joints"] | None = None,
    start: float = 0.0,
) -> Log:
    """R independent runs of a reference, each from rest, with all raw signals."""
    inputs, lead = loop_inputs(setup, reference, rng, runs, feedforward, start)
    n = setup.plant.robot.n
    size = 4 * n + setup.plant.memory_states
    initial = np.zeros((size, runs))
    initial[:n] = inputs[0, 1 : 1 + n]
    initial[size - 2 * n :] = observer_at_rest(setup.controller, inputs[0, 1 : 1 + n, 0])[:, None]
    outputs = _loop(setup, initial, inputs)
    signals = (outputs[:, i * n : (i + 1) * n] for i in range(5))
    return Log(inputs[:, 0], *signals, lead=lead, samples=len(reference))


def loop_inputs(  # noqa: PLR0917  # those of `run`
    setup: Setup,
    reference: Motion,
    rng: np.random.Generator,
    runs: int,
    feedforward: Float[ndarray, "samples joints"] | None,
    start: float,
) -> tuple[Float[ndarray, "all_samples inputs runs"], int]:
    """[t, q_d, dq_d, feedforward, disturbance] of every period, and the lead-in's length."""
    period, n = setup.controller.period, setup.plant.robot.n
    _check_sampling(reference, period)
    approach = lead_in(reference, setup.lead_in, period)
    lead = len(approach)
    parts = [approach, reference]
    if setup.lead_out > 0:
        parts.append(lead_out(reference, setup.lead_out, period))
    path = Motion.concatenate(parts)
    if feedforward is None:
        feedforward = np.zeros_like(reference.q)
    after = len(path) - lead - len(reference)
    forward = np.pad(feedforward, ((lead, after), (0, 0)), mode="edge")
    total = len(path)
    inputs = np.empty((total, 4 * n + 1, runs))
    inputs[:, 0] = start + period * (np.arange(total)[:, None] + total * np.arange(runs))
    for block, values in enumerate((path.q, path.dq, forward)):
        inputs[:, 1 + block * n : 1 + (block + 1) * n] = values[:, :, None]
    disturbance = setup.disturbance or Disturbance.none(n)
    inputs[:, 1 + 3 * n :] = disturbance.sample(total, runs, period, rng)
    return inputs, lead


def read_log(
    setup: Setup,
    log: Log,
    first: int,
    rng: np.random.Generator,
    *,
    name: str,
    role: Role,
) -> Recording:
    """What the sensors make of a log, from sample `first` of every run."""
    last = log.lead + log.samples
    torque = setup.sensors.torque(log.command, setup.controller.period, rng)[first:last]

    def stacked(x: Float[ndarray, "samples joints runs"]) -> Float[ndarray, "rows joints"]:
        return np.ascontiguousarray(x.transpose(2, 0, 1).reshape(-1, x.shape[1]))

    kept = len(torque)
    runs = log.t.shape[1]
    return Recording(
        name=name,
        role=role,
        t=np.ascontiguousarray(log.t[first:last].T).ravel(),
        q=stacked(log.measured[first:last]),
        tau=stacked(torque),
        dq=stacked(log.velocity[first:last]) if setup.sensors.logs_velocity else None,
        repetition=np.repeat(np.arange(runs), kept) if runs > 1 else None,
        source="simulation",
    )


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
    controller: Controller, q: Float[ndarray, "joints"]
) -> Float[ndarray, "observer"]:
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


def _loop(
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
    many = step.map(runs) if runs > 1 else step
    buffer, trigger = many.buffer()
    # CasADi stores (rows, runs) by columns: one run after another in memory.
    x, y = np.empty((runs, step.size1_in(0))), np.empty((runs, step.size1_out(0)))

    def evaluate(values: Float[ndarray, "inputs runs"]) -> Float[ndarray, "outputs runs"]:
        x[:] = values.T
        # The trigger is a bare pointer: naming the buffer and its function keeps them alive.
        _ = many
        buffer.set_arg(0, memoryview(x))
        buffer.set_res(0, memoryview(y))
        trigger()
        return y.T.copy()

    return evaluate


def _tiled(
    reference: Motion, feedforward: Float[ndarray, "samples joints"] | None, times: int
) -> tuple[Motion, Float[ndarray, "tiled joints"] | None]:
    step = reference.t[1] - reference.t[0]
    t = reference.t[0] + step * np.arange(times * len(reference))
    tile = (times, 1)
    played = Motion(t, *(np.tile(x, tile) for x in (reference.q, reference.dq, reference.ddq)))
    return played, None if feedforward is None else np.tile(feedforward, tile)


def _as_periods(recording: Recording, samples: int, step: float) -> Recording:
    count = len(recording) // samples
    return Recording(
        name=recording.name,
        role=recording.role,
        t=recording.t,
        q=recording.q,
        tau=recording.tau,
        dq=recording.dq,
        repetition=np.repeat(np.arange(count), samples),
        period=samples * step,
        source=recording.source,
    )


def _check_sampling(reference: Motion, period: float) -> None:
    steps = np.diff(reference.t)
    if len(steps) == 0 or np.abs(steps - period).max() > 1e-6 * period + 1e-9:
        raise ValueError(f"the reference must be sampled every {period:g} s, the control period")
