"""Mesh files of a URDF made readable for Drake, which takes neither STL nor COLLADA.

Drake is given an OBJ file of the same triangles. Coal's loader (Assimp) reads COLLADA and what
else there is; binary STL is read here, as that takes a tenth of the time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import coal
import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.spatial import ConvexHull, QhullError

from oed.robot.packages import find_packages

DRAWN_BY_DRAKE = (".obj", ".gltf", ".glb", ".vtk")
ELEMENTS = ("visual", "collision")
DETAIL = 1000  # of a mesh that is drawn: a thousandth of it is less than a pixel on a page
# What became of each mesh, drawn or as a hull.
Converted = dict[tuple[Path, bool], Path | None]


@dataclass(frozen=True)
class ReadableUrdf:
    """A URDF whose meshes Drake can read.

    Attributes:
        text: The file, its meshes named by absolute path.
        missing: Names of the meshes that could not be found or read, and are left out.
        missing_shapes: Those of them that are collision shapes.
    """

    text: str
    missing: tuple[str, ...]
    missing_shapes: tuple[str, ...]


def with_readable_meshes(
    text: str, source: Path, scratch: Path, packages: Mapping[str, Path] | None = None
) -> ReadableUrdf:
    """Convert what Drake cannot read, and leave out what nobody can.

    Args:
        text: A URDF.
        source: Its file, from which relative paths and packages are found.
        scratch: Folder for converted meshes; it must stay while the robot is drawn.
        packages: As of `find_mesh`.

    Raises:
        xml.etree.ElementTree.ParseError: If the text is not XML.
    """
    root = ElementTree.fromstring(text)  # noqa: S314  # the user's own robot file
    converted: Converted = {}
    missing: list[str] = []
    missing_shapes: list[str] = []
    for link in root.iter("link"):
        for element in [e for kind in ELEMENTS for e in link.findall(kind)]:
            for mesh in element.iter("mesh"):
                name = mesh.get("filename", "")
                is_hull = element.tag == "collision"
                found = find_mesh(name, source, packages)
                readable = _readable(found, scratch, converted, is_hull=is_hull)
                if readable is None:
                    missing.append(name)
                    missing_shapes += [name] if is_hull else []
                    link.remove(element)
                    break
                mesh.set("filename", str(readable))
    _define_once(root)
    edited = ElementTree.tostring(root, encoding="unicode")
    return ReadableUrdf(edited, tuple(missing), tuple(missing_shapes))


def _define_once(root: ElementTree.Element) -> None:
    """Let a material's first definition stand for all: Drake refuses a file with two.

    Drake reads the robot's own before those within links, wherever they stand in the file. A
    material without a name is nobody else's; one that is nowhere defined, which Drake refuses
    too, is left out.
    """
    defined: set[str] = set()
    for material in [*root.findall("material"), *root.iterfind("link//material")]:
        name = material.get("name", "")
        if not len(material) or not name:
            continue
        if name in defined:
            for child in list(material):
                material.remove(child)
        defined.add(name)
    for visual in root.iterfind("link/visual"):
        for material in visual.findall("material"):
            if not len(material) and material.get("name", "") not in defined:
                visual.remove(material)


def find_mesh(name: str, source: Path, packages: Mapping[str, Path] | None = None) -> Path | None:
    """The file that a URDF means: by path, or by a package.

    Args:
        name: As in the file.
        source: That file.
        packages: Folders of packages by name; others are looked for as by `find_packages`.
    """
    scheme, _, rest = name.rpartition("://")
    if scheme in ("", "file"):
        found = source.parent / rest
        return found if found.is_file() else None
    package, _, inside = rest.partition("/")
    given = (packages or {}).get(package)
    roots = find_packages(package, source) if given is None else (given,)
    return next((root / inside for root in roots if (root / inside).is_file()), None)


def load_triangles(path: Path) -> Float[ndarray, "triangles 3 3"]:
    """The three corners of every triangle [unit of the file].

    Raises:
        ValueError: If the file holds no mesh that can be read.
    """
    triangles = _binary_stl(path) if path.suffix.lower() == ".stl" else None
    if triangles is None:
        triangles = _by_assimp(path)
    if not len(triangles):
        raise ValueError(f"{path}: no triangles")
    return triangles


def write_obj(triangles: Float[ndarray, "triangles 3 3"], path: Path) -> None:
    """A Wavefront OBJ file, which counts from 1."""
    vertices, corners = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    lines = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in vertices.tolist()]
    faces = (corners.reshape(-1, 3) + 1).tolist()
    lines += [f"f {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _binary_stl(path: Path) -> Float[ndarray, "triangles 3 3"] | None:
    """The corners in a binary STL file, single precision; None if it is an ASCII one."""
    content = path.read_bytes()
    count = int.from_bytes(content[80:84], "little")
    if len(content) != 84 + 50 * count:
        return None
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return np.frombuffer(content, record, count, 84)["corners"].astype(float)


def _by_assimp(path: Path) -> Float[ndarray, "triangles 3 3"]:
    try:
        mesh = coal.MeshLoader().load(str(path), np.ones(3))
        triangles = [mesh.tri_indices(i) for i in range(mesh.num_tris)]
        corners = [(triangle[0], triangle[1], triangle[2]) for triangle in triangles]
    except (RuntimeError, ValueError) as error:
        raise ValueError(f"{path}: no mesh can be read: {error}") from error
    return np.array(mesh.vertices())[np.array(corners, dtype=int).reshape(-1, 3)]


def _readable(
    found: Path | None, scratch: Path, converted: Converted, *, is_hull: bool
) -> Path | None:
    """The mesh in a format of Drake's, converted at most once; None if that fails."""
    if found is None or found.suffix.lower() in DRAWN_BY_DRAKE:
        return found.resolve() if found is not None else None
    key = (found, is_hull)
    if key not in converted:
        target = scratch / f"{len(converted)}_{found.stem}.obj"
        try:
            triangles = load_triangles(found)
            write_obj(_hull(triangles) if is_hull else _as_drawn(triangles), target)
            converted[key] = target
        except ValueError:
            converted[key] = None
    return converted[key]


def _as_drawn(triangles: Float[ndarray, "triangles 3 3"]) -> Float[ndarray, "kept 3 3"]:
    """The mesh with its corners on a grid of its largest extent over `DETAIL`.

    No corner moves by more than half a step along any axis. What then has two corners in one place is no
    triangle, and numbers of few digits take little of a page.
    """
    step = float(np.ptp(triangles.reshape(-1, 3), axis=0).max()) / DETAIL
    if step == 0.0:
        return triangles
    decimals = int(np.ceil(-np.log10(step)))  # a decimal step is written with fewest digits
    placed = np.round(triangles, decimals)
    sides = placed - np.roll(placed, 1, axis=1)
    return placed[(sides != 0).any(axis=2).all(axis=1)]


def _hull(triangles: Float[ndarray, "triangles 3 3"]) -> Float[ndarray, "faces 3 3"]:
    """The convex hull, which is what Drake checks for contact; a flat mesh as it is."""
    try:
        hull = ConvexHull(triangles.reshape(-1, 3))
    except QhullError:
        return triangles
    return hull.points[hull.simplices]
