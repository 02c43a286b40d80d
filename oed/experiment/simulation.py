"""A virtual experiment: a true plant under sampled feedback, read through real sensors.

One control period of plant, controller and observer becomes a single CasADi function, and
all repetitions run through it side by side, in machine code where there is a compiler. For
small arms that is hundreds to thousands of times faster than real time, where a Drake
Diagram with systems in Python is about as fast as real time; `oed.experiment.drake_experiment`
is the same experiment on Drake, and the tests hold the two against each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.experiment.control_loop import SimulationDiverged, observer_at_rest, run_loop
from oed.experiment.disturbance import Disturbance
from oed.experiment.recording import Recording, Role
from oed.experiment.reference import lead_in, lead_out
from oed.experiment.setup import Setup

__all__ = ["Log", "Setup", "SimulationDiverged", "loop_inputs", "read_log", "run", "simulate"]


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
    outputs = run_loop(setup, initial, inputs)
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
