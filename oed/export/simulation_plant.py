"""A Drake plant of the identified robot, and a system with all effects that act in a simulation."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Diagram, DiagramBuilder, LeafSystem

from oed.dynamics.drake_plant import add_robot, coordinate_order
from oed.export.calibrated_robot import CalibratedRobot
from oed.export.effect_torque import SIGN_WIDTH, EffectTorque, whole_arm
from oed.export.model import Model

NATIVE = ("damping", "armature")  # what a plant's joint and actuator have
STEP = 1e-3  # [s] after which effects with a memory go on


class EffectDrive(LeafSystem):
    """Motor torque less that of the effects, joint by joint: what the plant's joints receive.

    Where an effect depends on the acceleration, as friction under load, the arm's own equation is
    solved for that first. What effects remember is a discrete state.
    """

    def __init__(
        self, model: Model, plant: MultibodyPlant, *, sign_width: float, step: float
    ) -> None:
        super().__init__()
        n = model.robot.n
        self._effects = EffectTorque.of(model, NATIVE, step, sign_width=sign_width)
        self._arm = whole_arm(model, step, sign_width=sign_width)
        self._order = coordinate_order(plant, model.robot)
        self._positions, self._velocities = plant.num_positions(), plant.num_velocities()
        self._state = self.DeclareVectorInputPort("state", self._positions + self._velocities)
        self._torque = self.DeclareVectorInputPort("torque", n)
        self.DeclareVectorOutputPort("force", self._velocities, self._force)
        # What is remembered begins where the arm is: at the first update, or call.
        self._memory = self.DeclareDiscreteState(len(self._effects.keeps))
        self._begun = self.DeclareDiscreteState(1)
        if self._effects.keeps:
            self.DeclarePeriodicDiscreteUpdateEvent(step, 0.0, self._go_on)

    def _force(self, context, output: BasicVector) -> None:  # pydrake's Context
        torque, _ = self._effect_torque(context)
        force = np.zeros(self._velocities)
        force[self._order] = self._torque.Eval(context) - torque
        output.SetFromVector(force)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape

    def _go_on(self, context, discrete) -> None:  # pydrake's Context and DiscreteValues
        _, following = self._effect_torque(context)
        discrete.set_value(self._memory, following)
        discrete.set_value(self._begun, [1.0])

    def _effect_torque(self, context) -> tuple[Float[ndarray, " joints"], Float[ndarray, " kept"]]:
        state = np.asarray(self._state.Eval(context))
        q, dq = state[: self._positions][self._order], state[self._positions :][self._order]
        memory = np.array(context.get_discrete_state(self._memory).value())
        if not context.get_discrete_state(self._begun).value()[0]:
            memory = self._effects.begin(q, dq)
        ddq = np.zeros_like(q)
        if self._effects.follows_acceleration:
            applied = np.asarray(self._torque.Eval(context))
            kept = memory if self._effects.keeps else np.zeros(0)
            ddq, _ = self._arm.acceleration(q, dq, kept, applied)
        return self._effects.torque(q, dq, ddq, memory)


def build_simulation_plant(calibrated: CalibratedRobot) -> MultibodyPlant:
    """A finished continuous plant with viscous friction and rotor inertia at its joints.

    What else the model has is no part of a MultibodyPlant's joint: see `build_simulation`.
    """
    plant = MultibodyPlant(time_step=0.0)
    add_robot(plant, calibrated.robot, actuated=True)
    for i, name in enumerate(calibrated.robot.joint_names):
        plant.GetJointByName(name).set_default_damping(max(0.0, float(calibrated.viscous[i])))
        actuator = plant.GetJointActuatorByName(name)
        actuator.set_default_gear_ratio(1.0)
        actuator.set_default_rotor_inertia(float(calibrated.rotor_inertia[i]))
    plant.Finalize()
    return plant


def build_simulation(
    model: Model, *, sign_width: float = SIGN_WIDTH, step: float = STEP
) -> tuple[Diagram, MultibodyPlant]:
    """A diagram that takes joint torques and gives the joint state.

    Args:
        model: To simulate, of bodies that can exist.
        sign_width: Velocity over which signs turn at least [rad/s or m/s]; 0 for the model's own.
        step: After which effects with a memory go on [s].

    Returns:
        A diagram with input port "torque" (n, in the order of the robot's joints) and output
        port "state" (2 n, in the plant's), and the plant inside it.
    """
    builder = DiagramBuilder()
    plant = build_simulation_plant(CalibratedRobot.of(model.torque_model, model.parameters))
    drive = EffectDrive(model, plant, sign_width=sign_width, step=step)
    builder.AddSystem(plant)
    builder.AddSystem(drive)
    builder.Connect(plant.get_state_output_port(), drive.GetInputPort("state"))
    builder.Connect(drive.get_output_port(), plant.get_applied_generalized_force_input_port())
    builder.ExportInput(drive.GetInputPort("torque"), "torque")
    builder.ExportOutput(plant.get_state_output_port(), "state")
    return builder.Build(), plant
