"""The virtual experiment as a Drake Diagram: the reference that the fast loop is held against.

    resolver and controller (discrete, 1 ms) --torque--> drive --torque--> MultibodyPlant
                 ^                                         ^                     |
                 +------------------ joint state ----------+---------------------+

The drive takes off every torque that is not the rigid body's: viscous friction, and the
bristles of stick and slip as continuous states.
"""

# pydrake's stubs want float64 arrays where ndarray is given, and lose the types of systems.
# pyright: reportArgumentType=false, reportCallIssue=false, reportReturnType=false
# pyright: reportIncompatibleMethodOverride=false, reportIndexIssue=false

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import BasicVector, Diagram, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink

from oed.dynamics.drake_plant import add_robot, coordinate_order
from oed.dynamics.effects import State
from oed.dynamics.motion import Motion
from oed.experiment.control_loop import observer_at_rest
from oed.experiment.setup import Setup
from oed.experiment.simulation import Log, loop_inputs

INTEGRATION_STEP = 2.5e-4  # [s]: four steps a control period, third order
STABLE_STEP = 1.5  # decay times a step; third-order Runge-Kutta is stable to 2.5


class Feedback(LeafSystem):
    """Sensor, observer and controller (17): samples the joints, holds the torque.

    The discrete state is [observer (2 n), command (n), measured q (n), observed dq (n),
    command plus disturbance (n)].
    """

    def __init__(self, setup: Setup, inputs: Float[ndarray, "samples inputs"]) -> None:
        super().__init__()
        controller, n = setup.controller, setup.plant.robot.n
        self.n, self.inputs, self.controller = n, inputs, controller
        self.resolution = np.array(setup.sensors.resolution)
        self.observer = controller.observer.discretised(controller.period)
        start = np.zeros(6 * n)
        start[: 2 * n] = observer_at_rest(controller, inputs[0, 1 : 1 + n])
        self.DeclareVectorInputPort("joints", 2 * n)
        state = self.DeclareDiscreteState(start)
        self.DeclareStateOutputPort("state", state)
        self.DeclareVectorOutputPort("applied", n, self._applied, {self.all_state_ticket()})
        self.DeclarePeriodicDiscreteUpdateEvent(controller.period, 0.0, self._update)

    def _applied(self, context, output: BasicVector) -> None:  # pydrake's Context
        output.SetFromVector(context.get_discrete_state_vector().value()[5 * self.n :])

    def _update(self, context, updated) -> None:  # Context, DiscreteValues
        n, controller = self.n, self.controller
        k = round(context.get_time() / controller.period)
        _, q_d, dq_d, forward, push = _split(self.inputs[min(k, len(self.inputs) - 1)], n)
        q = self.get_input_port().Eval(context)[:n]
        if self.resolution.size:
            q = (np.floor(q / self.resolution) + 0.5) * self.resolution
        s = context.get_discrete_state_vector().value()[: 2 * n].reshape(2, n).T
        A, B, D = self.observer
        velocity = s[:, 1] + D[:, 1] * q
        feedback = np.array(controller.stiffness) * (q_d - q)
        command = forward + feedback + np.array(controller.damping) * (dq_d - velocity)
        s = np.einsum("jab,jb->ja", A, s) + B * q[:, None]
        updated.get_mutable_vector().SetFromVector(
            np.concatenate([s.T.ravel(), command, q, velocity, command + push])
        )


class Drive(LeafSystem):
    """The held torque less friction: what reaches the rigid body."""

    def __init__(self, setup: Setup) -> None:
        super().__init__()
        self.setup, self.n = setup, setup.plant.robot.n
        self.joints = self.DeclareVectorInputPort("joints", 2 * self.n)
        self.applied = self.DeclareVectorInputPort("applied", self.n)
        self.memory = setup.plant.memory_states
        self.DeclareContinuousState(self.memory)
        self.DeclareVectorOutputPort("torque", self.n, self._torque)

    def _state(self, context) -> tuple[State, list[float]]:  # pydrake's Context
        x = self.joints.Eval(context).tolist()
        n = self.n
        memory = context.get_continuous_state_vector().CopyToVector().tolist()
        return State(context.get_time(), x[:n], x[n:], [0.0] * n), memory

    def _torque(self, context, output: BasicVector) -> None:  # pydrake's Context
        state, memory = self._state(context)
        hidden = self.setup.plant.add_hidden_torque(state, memory, [0.0] * self.n)
        output.SetFromVector(self.applied.Eval(context) - np.array(hidden))

    def DoCalcTimeDerivatives(self, context, derivatives) -> None:  # noqa: N802  # Drake
        """Rates of the bristles."""
        state, memory = self._state(context)
        rate = self.setup.plant.memory_rate(state, memory)
        derivatives.get_mutable_vector().SetFromVector(np.array(rate))


def build_diagram(
    setup: Setup, inputs: Float[ndarray, "samples inputs"]
) -> tuple[Diagram, MultibodyPlant, Feedback, VectorLogSink, VectorLogSink]:
    """Plant, drive and feedback wired up, with loggers of the joints and of the feedback."""
    builder = DiagramBuilder()
    plant = MultibodyPlant(time_step=0.0)
    builder.AddSystem(plant)
    add_robot(plant, setup.plant.robot)
    plant.Finalize()
    if coordinate_order(plant, setup.plant.robot) != list(range(setup.plant.robot.n)):
        raise ValueError("joints must stand in outward order for the Drake experiment")
    drive, feedback = Drive(setup), Feedback(setup, inputs)
    builder.AddSystem(drive)
    builder.AddSystem(feedback)
    joints = plant.get_state_output_port()
    builder.Connect(joints, feedback.get_input_port())
    builder.Connect(joints, drive.joints)
    builder.Connect(feedback.GetOutputPort("applied"), drive.applied)
    builder.Connect(drive.get_output_port(), plant.get_applied_generalized_force_input_port())
    period = setup.controller.period
    joint_log = LogVectorOutput(joints, builder, period)
    feedback_log = LogVectorOutput(feedback.GetOutputPort("state"), builder, period)
    return builder.Build(), plant, feedback, joint_log, feedback_log


def run_on_drake(setup: Setup, reference: Motion, rng: np.random.Generator, *, runs: int) -> Log:
    """As `oed.experiment.simulation.run`, on Drake, one run after another.

    Raises:
        ValueError: If the plant has torques that depend on the load: Drake's forward
            dynamics is explicit.
    """
    if setup.plant.extra:
        raise ValueError("extra torques may depend on the load; Drake runs those without")
    inputs, lead = loop_inputs(setup, reference, rng, runs, None, 0.0)
    logs = [_single_run(setup, np.ascontiguousarray(inputs[:, :, r])) for r in range(runs)]
    n = setup.plant.robot.n
    joints = np.stack([joint for joint, _ in logs], axis=2)
    held = np.stack([feedback for _, feedback in logs], axis=2)
    return Log(
        t=inputs[:, 0],
        q=joints[:, :n],
        dq=joints[:, n:],
        measured=held[:, 3 * n : 4 * n],
        velocity=held[:, 4 * n : 5 * n],
        command=held[:, 2 * n : 3 * n],
        lead=lead,
        samples=len(reference),
    )


def _single_run(
    setup: Setup, inputs: Float[ndarray, "samples inputs"]
) -> tuple[Float[ndarray, "samples joint_states"], Float[ndarray, "samples feedback_states"]]:
    diagram, plant, _, joint_log, feedback_log = build_diagram(setup, inputs)
    simulator = Simulator(diagram)
    n = setup.plant.robot.n
    fastest = setup.plant.fastest_memory() * np.abs(inputs[:, 1 + n : 1 + 2 * n]).max()
    config = SimulatorConfig(
        integration_scheme="runge_kutta3",
        max_step_size=min(INTEGRATION_STEP, STABLE_STEP / max(fastest, 1.0)),
        use_error_control=False,
    )
    ApplySimulatorConfig(config, simulator)
    context = simulator.get_mutable_context()
    plant.SetPositions(plant.GetMyMutableContextFromRoot(context), inputs[0, 1 : 1 + n])
    simulator.Initialize()
    simulator.AdvanceTo(len(inputs) * setup.controller.period)
    joints = joint_log.FindLog(context).data().T
    feedback = feedback_log.FindLog(context).data().T
    # A sample logged at an instant still shows what was held up to it.
    return joints[: len(inputs)], feedback[1 : len(inputs) + 1]


def _split(row: Float[ndarray, " inputs"], n: int) -> list[ndarray]:
    return np.split(row, np.cumsum([1, n, n, n]))
