"""A model for MuJoCo: MJCF, and a passive force for what that cannot say, in Python and as a plug-in."""

from __future__ import annotations

from oed.export.bodies import calibrated_robot
from oed.export.effect_torque import not_simulated
from oed.export.mjcf import write_mjcf
from oed.export.model import Model
from oed.export.model_file import NAME, write_model
from oed.export.mujoco_plugin import write_plugin
from oed.export.registry import Exported, Target
from oed.export.shapes import collect_shapes
from oed.in_comment import in_comment
from oed.report.json_file import write_atomically

SCRIPT = """\"\"\"{robot} in MuJoCo, its effects as a passive force; needs the packages mujoco and oed.\"\"\"

from pathlib import Path

import mujoco

from oed.export.mujoco_force import passive_force

HERE = Path(__file__).parent
model = mujoco.MjModel.from_xml_path(str(HERE / "robot_mujoco.xml"))
model.opt.timestep = {step!r}
data = mujoco.MjData(model)
mujoco.set_mjcb_passive(passive_force(HERE / "model.json", model))
try:
    for _ in range(1000):
        mujoco.mj_step(model, data)
    print(f"after {{data.time:.3g}} s without motor torque, q =", data.qpos)
finally:
    mujoco.set_mjcb_passive(None)
"""


def write(model: Model, target: Target) -> Exported:
    """Write robot_mujoco.xml, model.json and simulate_mujoco.py; for the plug-in, its source and scene."""
    calibrated = calibrated_robot(model)
    shapes = collect_shapes(model.robot, target.folder)
    # Signs are the passive force's: MuJoCo's dry friction turns in another way.
    path = write_mjcf(
        calibrated, target.folder / "robot_mujoco.xml", shapes=shapes, dry_friction=False
    )
    write_model(model, target.folder / NAME, home=target.home)
    text = SCRIPT.format(robot=in_comment(model.robot.name), step=target.step)
    write_atomically(target.folder / "simulate_mujoco.py", text)
    source, scene = write_plugin(model, target.folder, step=target.step, robot_file=path.name)
    files = ("simulate_mujoco.py", path.name, NAME, source.name, scene.name)
    notes = tuple(filter(None, [shapes.note]))
    use = f"python simulate_mujoco.py; without Python, the plug-in of {source.name}"
    return Exported(files, use, not_simulated(model), notes)
