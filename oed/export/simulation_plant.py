"""A Drake plant of the identified robot, with friction and rotors, ready to simulate."""

from __future__ import annotations

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Diagram, DiagramBuilder, LeafSystem

from oed.dynamics.drake_plant import add_robot, coordinate_order
from oed.export.calibrated_robot import CalibratedRobot

# Coulomb friction turns over this velocity: steps of a millisecond can follow it.
SIGN_WIDTH = 0.02  # [rad/s or m/s]


class JointDrive(LeafSystem):
    """Motor torque less Coulomb friction, joint by joint: what the plant's joints receive."""

    def __init__(
        self, calibrated: CalibratedRobot, plant: MultibodyPlant, sign_width: float
    ) -> None:
        super().__init__()
        self._coulomb, self._width = calibrated.coulomb, sign_width
        self._order = coordinate_order(plant, calibrated.robot)
        self._positions, self._velocities = plant.num_positions(), plant.num_velocities()
        self._state = self.DeclareVectorInputPort("state", self._positions + self._velocities)
        self._torque = self.DeclareVectorInputPort("torque", calibrated.robot.n)
        self.DeclareVectorOutputPort("force", self._velocities, self._force)

    def _force(self, context, output: BasicVector) -> None:  # pydrake's Context
        velocity = np.asarray(self._state.Eval(context))[self._positions :][self._order]
        force = np.zeros(self._velocities)
        friction = self._coulomb * np.tanh(velocity / self._width)
        force[self._order] = self._torque.Eval(context) - friction
        output.SetFromVector(force)  # pyright: ignore[reportArgumentType]  # the stub has the dtype in place of the shape


def build_simulation_plant(calibrated: CalibratedRobot) -> MultibodyPlant:
    """A finished continuous plant with viscous friction and rotor inertia at its joints.

    Coulomb friction is no part of a MultibodyPlant's joint: see `build_simulation`.
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
    calibrated: CalibratedRobot, *, sign_width: float = SIGN_WIDTH
) -> tuple[Diagram, MultibodyPlant]:
    """A diagram that takes joint torques and gives the joint state.

    Args:
        calibrated: To simulate.
        sign_width: Velocity over which Coulomb friction turns [rad/s or m/s].

    Returns:
        A diagram with input port "torque" (n, in the order of the robot's joints) and output
        port "state" (2 n, in the plant's), and the plant inside it.
    """
    builder = DiagramBuilder()
    plant = build_simulation_plant(calibrated)
    drive = JointDrive(calibrated, plant, sign_width)
    builder.AddSystem(plant)
    builder.AddSystem(drive)
    builder.Connect(plant.get_state_output_port(), drive.GetInputPort("state"))
    builder.Connect(drive.get_output_port(), plant.get_applied_generalized_force_input_port())
    builder.ExportInput(drive.GetInputPort("torque"), "torque")
    builder.ExportOutput(plant.get_state_output_port(), "state")
    return builder.Build(), plant
