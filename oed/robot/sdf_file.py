"""An SDF file as a text whose meshes and included files are found wherever it is read."""

from __future__ import annotations

from pathlib import Path

from oed.robot.xml_tree import parse_xml


def located(text: str, place: Path) -> str:
    """The text with each relative URI made a full one.

    Args:
        text: Of the file.
        place: The file, from whose folder SDF's relative URIs count.
    """
    tree = parse_xml(text.encode(), str(place))
    folder = place.resolve().parent
    for uri in tree.root.iter("uri"):
        name = (uri.text or "").strip()
        if name and "://" not in name:
            uri.text = (folder / name).as_uri()
    return tree.text()
