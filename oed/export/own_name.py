"""The name that a robot has in its own file."""

from __future__ import annotations

from oed.robot import Robot
from oed.robot.xml_tree import parse_xml


def own_name(robot: Robot) -> str:
    """As its file says; the file's own name where it says nothing."""
    file = robot.description
    if file is None:
        return robot.name
    root = parse_xml(file.text.encode(), str(file.path)).root
    model = root.find("model") if file.format == "sdf" else root
    named = None if model is None else model.get("model" if file.format == "mjcf" else "name")
    return named or robot.name
