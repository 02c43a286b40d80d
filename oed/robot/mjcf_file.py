"""An MJCF file's text without its meshes: Drake stops at those that are absent or not OBJ.

Nor does Drake know the suffix .mjcf, whose text it reads.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

KNOWN, UNKNOWN = ".xml", ".mjcf"  # to Drake


def without_meshes(path: Path) -> str | None:
    """The text of a file without mesh assets and the geoms that use them.

    A body keeps the inertia that is stated; one that would be that of a mesh is lost.

    Returns:
        None where that is no help: of no MJCF, of one that includes other files, which are not
        found from its text, and of one that is known to Drake and has no meshes.
    """
    suffix = path.suffix.lower()
    if suffix not in (KNOWN, UNKNOWN):
        return None
    try:
        root = ElementTree.fromstring(path.read_bytes())  # noqa: S314  # the user's own robot file
    except ElementTree.ParseError:
        return None
    has_meshes = root.find(".//asset/mesh") is not None
    if root.find(".//include") is not None or (suffix == KNOWN and not has_meshes):
        return None
    for parent in list(root.iter()):
        for child in list(parent):
            is_asset = parent.tag == "asset" and child.tag == "mesh"
            if is_asset or (child.tag == "geom" and child.get("mesh") is not None):
                parent.remove(child)
    return ElementTree.tostring(root, encoding="unicode")
