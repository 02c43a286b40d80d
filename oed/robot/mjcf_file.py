"""An MJCF file as one text that stands alone: nothing is included, and meshes have full paths.

Drake knows no <include>, needs the model's name, and stops at meshes that are absent or not OBJ.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

from oed.errors import RobotError

MOST_INCLUDES = 20  # one within another
Parse = Callable[[Path], ElementTree.Element]


def stand_alone(root: ElementTree.Element, path: Path, parse: Parse) -> None:
    """Take in, in place, what an MJCF file includes, and name its meshes by their full paths.

    Args:
        root: Of the file.
        path: The file, from whose folder MuJoCo finds what is included.
        parse: Of an included file.

    Raises:
        RobotError: If files include one another, or one is missing.
    """
    _take_in(root, path, parse, (path.resolve(),))
    if not root.get("model"):
        root.set("model", path.stem)
    folder = path.resolve().parent
    compilers = root.findall("compiler")
    for compiler in compilers:
        meshes = compiler.attrib.pop("meshdir", compiler.get("assetdir", ""))
        folder = folder / meshes
    for mesh in root.iterfind("asset/mesh"):
        if mesh.get("file"):
            mesh.set("name", mesh.get("name") or Path(mesh.get("file", "")).stem)
            mesh.set("file", str(folder / mesh.get("file", "")))


def without_meshes(root: ElementTree.Element) -> tuple[str, ...]:
    """Leave out, in place, mesh assets and the geoms that use them.

    A body keeps the inertia that is stated; one that would be that of a mesh is lost.

    Returns:
        Names of the bodies that lose theirs.
    """
    lost = tuple(
        body.get("name", "without a name")
        for body in root.iter("body")
        if body.find("inertial") is None
        and any(geom.get("mesh") is not None for geom in body.findall("geom"))
    )
    for parent in list(root.iter()):
        for child in list(parent):
            is_asset = parent.tag == "asset" and child.tag == "mesh"
            if is_asset or (child.tag == "geom" and child.get("mesh") is not None):
                parent.remove(child)
    return lost


def _take_in(
    element: ElementTree.Element, path: Path, parse: Parse, above: tuple[Path, ...]
) -> None:
    for i, child in reversed(list(enumerate(element))):
        if child.tag != "include":
            _take_in(child, path, parse, above)
            continue
        included = path.resolve().parent / child.get("file", "")
        if included.resolve() in above or len(above) > MOST_INCLUDES:
            raise RobotError(f"{path}: files include one another by {child.get('file')!r}")
        root = parse(included)
        _take_in(root, path, parse, (*above, included.resolve()))
        element[i : i + 1] = list(root)


def loops(root: ElementTree.Element) -> tuple[tuple[str, str], ...]:
    """Pairs of bodies that <connect> or <weld> ties to each other; "world" where one is left out."""
    return tuple(
        (element.get("body1", ""), element.get("body2", "world"))
        for kind in ("connect", "weld")
        for element in root.iterfind(f"equality/{kind}")
        if element.get("body1") and element.get("active", "true") != "false"
    )
