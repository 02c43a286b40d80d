"""A model for Drake: a plant, and a system with the torque of all effects."""

from __future__ import annotations

from oed.export.bodies import calibrated_robot
from oed.export.effect_torque import not_simulated
from oed.export.model import Model
from oed.export.model_file import NAME, write_model
from oed.export.registry import Exported, Target
from oed.in_comment import in_comment
from oed.report.json_file import write_atomically

SCRIPT = """\"\"\"{robot} in Drake with all its effects; needs the packages drake and oed.\"\"\"

from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator

import oed
from oed.export.simulation_plant import build_simulation

model = oed.load_model(Path(__file__).parent / "model.json")
diagram, plant = build_simulation(model, step={step!r})
simulator = Simulator(diagram)
context = simulator.get_mutable_context()
diagram.GetInputPort("torque").FixValue(context, np.zeros({joints}))
simulator.AdvanceTo(1.0)
state = diagram.GetOutputPort("state").Eval(context)
print("after 1 s without motor torque, q =", state[: plant.num_positions()])
"""


def write(model: Model, target: Target) -> Exported:
    """Write model.json and simulate_drake.py."""
    calibrated_robot(model)  # refuses what is no body
    write_model(model, target.folder / NAME, home=target.home)
    text = SCRIPT.format(robot=in_comment(model.robot.name), joints=model.robot.n, step=target.step)
    write_atomically(target.folder / "simulate_drake.py", text)
    files = ("simulate_drake.py", NAME)
    return Exported(files, "python simulate_drake.py", not_simulated(model))
