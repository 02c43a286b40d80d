"""Drake accepts robots whose materials are defined twice, and keeps their colours."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from oed.design.meshes import with_readable_meshes
from tests.design.tetrahedron import robot_text

RED, BLUE, DEFAULT = "1 0 0 1", "0 0 1 1", "none"


def material(name: str, colour: str) -> str:
    return f'<material name="{name}"><color rgba="{colour}"/></material>'


def boxed(*materials: str) -> str:
    box = '<geometry><box size="1 1 1"/></geometry>'
    return "".join(f"<visual>{box}{m}</visual>" for m in materials)


def drakes_colours(text: str, path: Path) -> list[str]:
    """Colour of every visual shape as Drake reads it."""
    path.write_text(text)
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    Parser(plant).AddModels(path)
    inspector = scene_graph.model_inspector()
    properties = [inspector.GetIllustrationProperties(g) for g in inspector.GetAllGeometryIds()]
    return [
        " ".join(f"{x:g}" for x in p.GetProperty("phong", "diffuse").rgba)
        if p.HasProperty("phong", "diffuse")
        else DEFAULT
        for p in properties
    ]


@pytest.mark.parametrize(
    ("text", "colours"),
    [
        (robot_text(boxed(material("m", RED), material("m", BLUE))), [RED, RED]),
        (robot_text(boxed(material("m", RED)), materials=material("m", BLUE)), [BLUE]),
        (
            robot_text(boxed(material("m", RED))).replace("</robot>", material("m", BLUE))
            + "</robot>",
            [BLUE],
        ),
        (robot_text(boxed(material("m", RED), '<material name="m"/>')), [RED, RED]),
        (robot_text(boxed(material("m", RED), material("n", BLUE))), [RED, BLUE]),
        (robot_text(boxed(material("", RED), material("", BLUE))), [RED, BLUE]),
        (robot_text(boxed(material("m", RED), '<material name="n"/>')), [DEFAULT, RED]),
    ],
    ids=[
        "twice_in_a_link",
        "first_in_the_robot",
        "last_in_the_robot",
        "used",
        "two",
        "unnamed",
        "undefined",
    ],
)
def test_drake_accepts_a_material_defined_twice(
    text: str, colours: list[str], tmp_path: Path
) -> None:
    found = with_readable_meshes(text, tmp_path / "r.urdf", tmp_path)
    assert sorted(drakes_colours(found.text, tmp_path / "r.urdf")) == sorted(colours)
