"""A model for NumPy: model.json, which this package evaluates, and a script that does.

The columns of an effect are written once, in this package; a copy without it would be a second truth.
"""

from __future__ import annotations

from oed.export.model import Model
from oed.export.model_file import NAME, write_model
from oed.export.registry import Exported, Target
from oed.in_comment import in_comment
from oed.report.json_file import write_atomically

SCRIPT = """\"\"\"Torque of {robot} by its model: along a motion, and one instant after another.\"\"\"

from pathlib import Path

import numpy as np

import oed
from oed.export.predictor import Predictor, Running

model = oed.load_model(Path(__file__).parent / "model.json")
joints = {joints}
t = np.arange(0.0, 1.0, {step!r})[:, None]
q, dq, ddq = (np.tile(x, joints) for x in (0.1 * np.sin(t), 0.1 * np.cos(t), -0.1 * np.sin(t)))

print("along a motion [N m]:", model.torque(q, dq, ddq, t=t[:, 0])[-1])
now = Running(Predictor.of(model, {step!r}))
for instant in zip(q, dq, ddq, strict=True):
    tau = now(*instant)
print("instant by instant  :", tau)
"""


def write(model: Model, target: Target) -> Exported:
    """Write model.json and predict.py."""
    write_model(model, target.folder / NAME, home=target.home)
    text = SCRIPT.format(robot=in_comment(model.robot.name), joints=model.robot.n, step=target.step)
    write_atomically(target.folder / "predict.py", text)
    return Exported((NAME, "predict.py"), "python predict.py")
