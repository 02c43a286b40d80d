"""What a robot's file calls things is no code, wherever it is written."""

import ast
import dataclasses
import re

import pytest

from oed.export.kinds import to_c, to_numpy
from oed.export.mujoco_plugin import write_plugin
from oed.export.registry import Target
from oed.in_comment import in_comment
from tests.dynamics.effects.arms import scara
from tests.export.every_effect import model_with

NAMES = ('"""\nimport os\n"""', "*/ int taken; /*", "arm\\", "arm\u2028import os")


@pytest.mark.parametrize("name", NAMES)
def test_a_robot_of_any_name_is_a_comment(tmp_path, name):
    robot = dataclasses.replace(scara(), name=name)
    model, _ = model_with("stribeck", robot=robot, duration=0.1)
    target = Target(tmp_path, tmp_path, 0.001)
    to_numpy.write(model, target)
    script = ast.parse((tmp_path / "predict.py").read_text(encoding="utf-8"))
    imported = {
        each.name for node in script.body if isinstance(node, ast.Import) for each in node.names
    }
    assert imported == {"numpy", "oed"}
    to_c.write(model, target)
    source, _ = write_plugin(model, tmp_path, step=0.001)
    for file in (tmp_path / "oed_model.h", source):
        code = re.sub(r"/\*.*?\*/", "", file.read_text(encoding="utf-8"), flags=re.DOTALL)
        assert "int taken" not in code


def test_usual_names_are_left_as_they_are():
    assert in_comment("ur5e (lab 3), Gelenk_ä") == "ur5e (lab 3), Gelenk_ä"
