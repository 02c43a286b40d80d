"""Small valid inputs of the commands: robots of every format, data sets, a model."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from oed.dynamics.motion import Motion
from oed.dynamics.newton_euler import rigid_body_torque
from oed.export.model_file import write_model
from oed.robot import Robot, imi_scara
from tests.export.every_effect import model_with
from tests.robot.test_mjcf_file import ARM as MJCF
from tests.robot.test_xacro_file import HEAD, LENGTH

URDF = """\
<robot name="arm">
  <link name="base"/>
  <joint name="joint_1" type="revolute"><parent link="base"/><child link="link_1"/>
    <origin xyz="0 0 0.1" rpy="0 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2.5" upper="2.5" velocity="4" effort="60"/></joint>
  <link name="link_1"><inertial><origin xyz="0.2 0 0.02"/><mass value="3"/>
    <inertia ixx="0.02" iyy="0.05" izz="0.05" ixy="0.001" ixz="0.002" iyz="0"/></inertial></link>
  <joint name="joint_2" type="revolute"><parent link="link_1"/><child link="link_2"/>
    <origin xyz="0.4 0 0" rpy="1.5708 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="5" effort="40"/></joint>
  <link name="link_2"><inertial><origin xyz="0.15 0.01 0"/><mass value="1.5"/>
    <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0.001" iyz="0"/></inertial></link>
</robot>
"""


SDF = """\
<sdf version="1.9"><model name="arm"><link name="base"/>
  <link name="upper"><pose relative_to="turn">0 0 0 0 0 0</pose><inertial>
    <pose>0.1 0 0 0 0 0</pose><mass>2</mass><inertia><ixx>0.02</ixx><iyy>0.03</iyy><izz>0.04</izz>
    </inertia></inertial></link>
  <joint name="turn" type="revolute"><pose relative_to="base">0 0 0.1 0 0.4 0</pose>
    <parent>base</parent><child>upper</child><axis><xyz>0 0.6 0.8</xyz>
    <limit><lower>-1</lower><upper>1</upper><velocity>3</velocity></limit></axis></joint>
</model></sdf>
"""


DH = """\
convention = "standard"
[[joint]]
a = 0.3
alpha = 1.5708
d = 0.1
lower = -2.0
upper = 2.0
velocity = 3.0
effort = 50.0
mass = 2.0
com = [-0.1, 0.0, 0.0]
inertia = [0.01, 0.0, 0.0, 0.02, 0.0, 0.02]
[[joint]]
a = 0.2
alpha = 0.0
kind = "prismatic"
lower = 0.0
upper = 0.3
"""


MANIFEST = """\
format = 1
name = "small"
source = "a formula"
licence = "CC0"
robot = "builtin:imi_scara"
joints = ["joint_1", "joint_2"]
gravity = [0.0, 0.0, -9.81]
torque = "measured"

[[recording]]
file = "estimation.csv"
role = "estimation"
repetitions = 4
period = 2.0

[[recording]]
file = "validation.csv"
role = "validation"
"""


ROBOTS = {
    "robot.urdf": URDF,
    "arm.xml": MJCF.format(assets="", geom=""),
    "arm.sdf": SDF,
    "dh.toml": DH,
    "arm.urdf.xacro": URDF.replace('<robot name="arm">', HEAD + LENGTH).replace(
        '"0.4 0', '"${l} 0'
    ),
}


RATE = 50.0  # [Hz]


LOAD = (1.5, 0.075, -0.03, 0.0, 0.005, 0.0, 0.0, 0.008, 0.0, 0.008)  # ten inertial parameters
HANGING = "[0.0, -9.81, 0.0]"  # the built-in arm in a vertical plane, where a load weighs


@cache
def recording(seed: int, load: tuple[float, ...] | None = None) -> str:
    """Four repetitions of two seconds of the built-in arm, with friction and noise, as CSV.

    Args:
        seed: Of the motion and the noise.
        load: Inertial parameters of what the arm holds; it hangs then.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(0, 8, 1 / RATE)
    q, dq, ddq = (np.zeros((len(t), 2)) for _ in range(3))
    for k in range(1, 5):
        w, (a, b) = k * np.pi, rng.uniform(-0.3, 0.3, (2, 2)) / k
        q += a * np.sin(w * t)[:, None] + b * np.cos(w * t)[:, None]
        dq += w * (a * np.cos(w * t)[:, None] - b * np.sin(w * t)[:, None])
        ddq -= w**2 * (a * np.sin(w * t)[:, None] + b * np.cos(w * t)[:, None])
    tau = rigid_body_torque(_arm(load), Motion(t, q, dq, ddq))
    tau += 2.0 * np.sign(dq) + 3.0 * dq + rng.normal(0, 0.1, tau.shape)
    rows = np.column_stack([t, q, tau])
    lines = [",".join(f"{x:.7g}" for x in row) for row in rows]
    return "t,q_1,q_2,tau_1,tau_2\n" + "\n".join(lines) + "\n"


def _arm(load: tuple[float, ...] | None) -> Robot:
    if load is None:
        return imi_scara()
    robot = imi_scara().with_gravity(np.array([0.0, -9.81, 0.0]))
    parameters = robot.parameters.copy()
    parameters[-10:] += load
    return robot.with_parameters(parameters)


def hanging(*, load: bool) -> dict[str, str]:
    """Files of a data set of the arm in a vertical plane, with the load or without it."""
    manifest = MANIFEST.split('\n[[recording]]\nfile = "validation', maxsplit=1)[0]
    return {
        "dataset.toml": manifest.replace("[0.0, 0.0, -9.81]", HANGING),
        "estimation.csv": recording(2 + load, LOAD if load else (0.0,) * 10),
    }


@cache
def model() -> str:
    """A model.json of the built-in arm, with effects that a diagnosis found."""
    found, _ = model_with("stribeck", "load_dependent_friction", "time_delay")
    with tempfile.TemporaryDirectory() as folder:
        return write_model(found, Path(folder) / "model.json").read_text(encoding="utf-8")
