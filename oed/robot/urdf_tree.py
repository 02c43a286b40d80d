"""Whether the links and joints of a URDF form one tree, and what is done where they nearly do."""

from __future__ import annotations

from collections import Counter
from xml.etree import ElementTree

from oed.errors import RobotError

MOVABLE = ("revolute", "continuous", "prismatic")
FREE = ("floating", "planar")  # of several degrees of freedom
KINDS = (*MOVABLE, *FREE, "fixed")


def check_tree(root: ElementTree.Element, where: str) -> tuple[str, ...]:
    """Refuse what is no tree; fix to the base what stands free of it.

    Args:
        root: Of the URDF; free joints below the first that moves become fixed in place, and
            further roots are fixed to the first.
        where: Name of the file, for the message.

    Returns:
        Notes on what was fixed.

    Raises:
        RobotError: Naming the link or joint: two of one name, a link that is not there, with two
            parents, or in a cycle, or a joint of several degrees of freedom inside a chain.
    """
    links = _names(root, "link", where)
    joints = _names(root, "joint", where)
    inboard = _inboard(joints, links, where)
    roots = [name for name in links if name not in inboard]
    _check_cycles(links, inboard, where)
    notes = []
    for name, joint in joints.items():
        if joint.get("type") in FREE:
            notes.append(_fixed_in_place(name, joint, inboard, where))
    if len(roots) > 1:
        for i, other in enumerate(roots[1:]):
            fixed = ElementTree.SubElement(root, "joint", name=f"_base_{i}", type="fixed")
            ElementTree.SubElement(fixed, "parent", link=roots[0])
            ElementTree.SubElement(fixed, "child", link=other)
        shown = ", ".join(roots[:5])
        notes.append(
            f"links {shown}{' …' if len(roots) > 5 else ''} have no parent: all are taken as "
            "fixed to one base"
        )
    return tuple(notes)


def _names(root: ElementTree.Element, kind: str, where: str) -> dict[str, ElementTree.Element]:
    elements = root.findall(kind)
    for element in elements:
        if not element.get("name", "").strip():
            raise RobotError(f"{where}: a {kind} has no name; give it one")
    count = Counter(element.get("name", "") for element in elements)
    for name, times in count.items():
        if times > 1:
            raise RobotError(f"{where}: {times} {kind}s are called {name!r}; rename all but one")
    return {element.get("name", ""): element for element in elements}


def _inboard(
    joints: dict[str, ElementTree.Element], links: dict[str, ElementTree.Element], where: str
) -> dict[str, ElementTree.Element]:
    """The joint that carries each link, by the link's name."""
    inboard: dict[str, ElementTree.Element] = {}
    for name, joint in joints.items():
        kind = joint.get("type", "")
        if kind not in KINDS:
            what = f"is of type {kind!r}" if kind else "has no type"
            raise RobotError(f"{where}: joint {name!r} {what}; a URDF knows {', '.join(KINDS)}")
        ends = {end: _link(joint, end) for end in ("parent", "child")}
        for end, link in ends.items():
            if not link:
                raise RobotError(f"{where}: joint {name!r} names no {end} link")
            if link not in links:
                raise RobotError(f"{where}: joint {name!r}: its {end} {link!r} is no link here")
        child = ends["child"]
        if child in inboard:
            first = inboard[child].get("name")
            raise RobotError(
                f"{where}: link {child!r} is the child of two joints, {first!r} and {name!r}: that "
                "is a closed loop, and only open chains can be modelled; cut the loop by removing "
                "one of them"
            )
        inboard[child] = joint
    return inboard


def _check_cycles(
    links: dict[str, ElementTree.Element], inboard: dict[str, ElementTree.Element], where: str
) -> None:
    sound: set[str] = set()
    for start in links:
        path: list[str] = []
        at = start
        while at in inboard and at not in sound:
            if at in path:
                raise RobotError(
                    f"{where}: links {', '.join(path[path.index(at) :][:8])} carry each other in "
                    "a circle; one of them must hang from the base"
                )
            path.append(at)
            at = _link(inboard[at], "parent")
        sound.update(path)


def _fixed_in_place(
    name: str,
    joint: ElementTree.Element,
    inboard: dict[str, ElementTree.Element],
    where: str,
) -> str:
    """Make a joint of several degrees of freedom a fixed one, if nothing that moves carries it."""
    kind = joint.get("type")
    at = _link(joint, "parent")
    while at in inboard:
        above = inboard[at]
        if above.get("type") in MOVABLE:
            raise RobotError(
                f"{where}: joint {name!r} is {kind} and hangs from joint {above.get('name')!r}: "
                "what moves so freely inside a chain cannot be modelled; make it fixed, or "
                "remove what it carries"
            )
        at = _link(above, "parent")
    joint.set("type", "fixed")
    for element in joint.findall("axis") + joint.findall("limit"):
        joint.remove(element)
    return f"joint {name!r} is {kind}: taken as fixed, as an arm stands on its base"


def _link(joint: ElementTree.Element, end: str) -> str:
    element = joint.find(end)
    return "" if element is None else element.get("link", "")
