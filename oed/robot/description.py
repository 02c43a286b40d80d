"""The one place that opens a robot's file, whatever its format.

What it returns is the text that every program is given afterwards: Drake, Pinocchio, the scene
and the export. So all of them compute the same robot, and none can fail where another did not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

from oed.errors import RobotError
from oed.input_file import ROBOT_FILE, UnreadableFile, read_file
from oed.robot import mjcf_file
from oed.robot.dh_table import read_dh_table
from oed.robot.mimics import Mimic, read_mimics
from oed.robot.possible_inertia import InertiaFault, replace_impossible
from oed.robot.urdf_file import read_efforts
from oed.robot.urdf_numbers import check_numbers
from oed.robot.urdf_tree import check_tree
from oed.robot.xacro_file import expand_xacro, is_xacro
from oed.robot.xml_tree import XmlTree, parse_xml

Format = Literal["urdf", "sdf", "mjcf"]
FORMATS: dict[str, Format] = {"robot": "urdf", "sdf": "sdf", "mujoco": "mjcf"}
SUFFIXES = (".urdf", ".xacro", ".sdf", ".xml", ".mjcf", ".toml")
# A humanoid with hands has two hundred; what walks a chain of thousands would not end.
MOST_LINKS = 500
LINKS = {"urdf": "link", "sdf": "link", "mjcf": "body"}
KNOWN = "a URDF, xacro, SDF or MJCF file, or a table of Denavit-Hartenberg parameters (TOML)"


@dataclass(frozen=True)
class RobotDescription:
    """A robot's file as all programs read it.

    Attributes:
        source: As the user named it.
        path: The file.
        place: The file beside which meshes, packages and included files are looked for: `path`, or the
            one that `path` is a copy of.
        format: Of `text`; xacro and tables of Denavit-Hartenberg parameters become URDF.
        text: The file, expanded and with what cannot be replaced.
        is_as_written: Whether `text` says what the file says, so that the file may be copied.
        effort: Largest torque of each joint whose URDF states one [N m or N].
        mimics: Joints that follow another, by name.
        faults: By link, what is wrong with its inertia in the file; `text` holds another.
        loops: Pairs of bodies that are tied to each other beside the joints between them.
        notes: What was replaced, fixed or assumed.
        packages: Folders of ROS packages that the user named; others are looked for.
    """

    source: str
    path: Path
    place: Path
    format: Format
    text: str
    is_as_written: bool = True
    effort: Mapping[str, float] = field(default_factory=dict)
    mimics: Mapping[str, Mimic] = field(default_factory=dict)
    faults: Mapping[str, InertiaFault] = field(default_factory=dict)
    loops: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()
    packages: Mapping[str, Path] = field(default_factory=dict)


def read_description(source: str | Path, *, place: Path | None = None) -> RobotDescription:
    """Open a robot's file.

    Args:
        source: Path of a URDF, xacro, SDF or MJCF file or of a table of Denavit-Hartenberg
            parameters; that of a xacro file may be followed by its arguments, "NAME:=VALUE".
        place: The file that it is a copy of, in whose surroundings meshes are looked for; None where
            it lies in its own.

    Raises:
        RobotError: In one line that names the file, if it cannot be read, is no robot's, or
            contradicts itself.
    """
    path, arguments = _split(source)
    place = path if place is None else place
    content = _read(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise RobotError(f"{path}: unknown kind of robot file; expected {KNOWN}")
    if suffix == ".toml":
        tree = XmlTree(read_dh_table(content, str(path), path.stem), {})
        return _of_urdf(source, path, tree, place, is_as_written=False)
    is_macro = suffix == ".xacro" or b"<xacro:" in content
    if is_macro:
        parse_if_possible = None
    else:
        parse_if_possible = parse_xml(content, str(path))
        is_macro = parse_if_possible.root.tag == "robot" and is_xacro(parse_if_possible.root)
    if is_macro or parse_if_possible is None:
        expanded = parse_xml(expand_xacro(path, arguments), f"{path}, expanded")
        return _of_urdf(source, path, expanded, place, is_as_written=False)
    tree = parse_if_possible
    file_format = FORMATS.get(str(tree.root.tag).rpartition("}")[2])
    if file_format is None:
        raise RobotError(f"{path}: its outermost element is <{tree.root.tag}>; expected {KNOWN}")
    if file_format == "urdf":
        return _of_urdf(source, path, tree, place, is_as_written=True)
    return _of_other(source, path, tree, place, file_format)


def _split(source: str | Path) -> tuple[Path, tuple[str, ...]]:
    """The file, and the xacro arguments that stand after it."""
    words = str(source).split(" ")
    count = 0
    while count < len(words) - 1 and ":=" in words[-1 - count]:
        count += 1
    name = " ".join(words[: len(words) - count])
    return Path(name), tuple(words[len(words) - count :])


def _check_size(root: ElementTree.Element, file_format: Format, where: str) -> None:
    count = sum(1 for _ in root.iter(LINKS[file_format]))
    if count > MOST_LINKS:
        raise RobotError(
            f"{where}: describes {count} links, more than {MOST_LINKS}; give the arm alone"
        )


def _read(path: Path) -> bytes:
    try:
        return read_file(path, ROBOT_FILE)
    except FileNotFoundError as error:
        raise RobotError(f"{path}: no such robot file; give {KNOWN}") from error
    except UnreadableFile as error:
        raise RobotError(str(error)) from error


def _of_urdf(
    source: str | Path, path: Path, tree: XmlTree, place: Path, *, is_as_written: bool
) -> RobotDescription:
    root, where = tree.root, str(path)
    if root.tag != "robot":
        raise RobotError(f"{where}: its outermost element is <{root.tag}>, not <robot>")
    if not root.get("name", "").strip():
        root.set("name", path.stem)
    _check_size(root, "urdf", where)
    check_numbers(root, where)
    fixed = check_tree(root, where)
    efforts = read_efforts(root, where)
    mimics, of_mimics = read_mimics(root, "urdf", where)
    faults = replace_impossible(root, "urdf")
    return RobotDescription(
        source=str(source),
        path=path,
        place=place,
        format="urdf",
        text=tree.text(),
        is_as_written=is_as_written,
        effort=efforts,
        mimics=mimics,
        faults=faults,
        notes=(*fixed, *of_mimics),
    )


def _of_other(
    source: str | Path, path: Path, tree: XmlTree, place: Path, file_format: Format
) -> RobotDescription:
    root, where = tree.root, str(path)
    if file_format == "mjcf":
        mjcf_file.stand_alone(root, place, _included)
    _check_size(root, file_format, where)
    mimics, of_mimics = read_mimics(root, file_format, where)
    faults = replace_impossible(root, file_format)
    return RobotDescription(
        source=str(source),
        path=path,
        place=place,
        format=file_format,
        text=tree.text(),
        mimics=mimics,
        faults=faults,
        loops=mjcf_file.loops(root) if file_format == "mjcf" else (),
        notes=of_mimics,
    )


def _included(path: Path) -> ElementTree.Element:
    return parse_xml(_read(path), str(path)).root
