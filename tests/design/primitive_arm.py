"""Small arms of spheres and boxes, whose distances are known in closed form."""

from __future__ import annotations

from pathlib import Path

from oed.robot import Robot, load_robot

LENGTH = 0.5  # [m] of each link
TIP = 0.1  # [m] radius of the sphere at the end of the second link


def sphere(radius: float, at: str = "0 0 0", kind: str = "collision") -> str:
    """A shape of a link, in the link's frame."""
    return _shape(f'<sphere radius="{radius}"/>', at, kind)


def box(size: str, at: str = "0 0 0", kind: str = "collision") -> str:
    """The same, with the lengths of the edges."""
    return _shape(f'<box size="{size}"/>', at, kind)


def planar_arm(
    folder: Path,
    *,
    base: str = "",
    upper: str = "",
    lower: str = "",
    joints: tuple[str, ...] = ("shoulder", "elbow"),
    reach: tuple[float, float] = (3.0, 3.0),
    locked: dict[str, float] | None = None,
) -> Robot:
    """Two links of `LENGTH` that turn about z; the shapes of base and links in their frames.

    Position within +-`reach`, velocity within +-2 rad/s, acceleration within +-8 rad/s^2.
    """
    text = f"""<robot name="planar">
<link name="base">{base}</link>
<link name="upper">{_inertial(4.0)}{upper}</link>
<link name="lower">{_inertial(2.0)}{lower}</link>
{_joint("shoulder", "base", "upper", "0 0 0", reach[0])}
{_joint("elbow", "upper", "lower", f"{LENGTH} 0 0", reach[1])}
</robot>"""
    path = folder / "planar.urdf"
    path.write_text(text, encoding="utf-8")
    return load_robot(path, joints=joints, locked=locked)


def _shape(geometry: str, at: str, kind: str) -> str:
    return f'<{kind}><origin xyz="{at}"/><geometry>{geometry}</geometry></{kind}>'


def _inertial(mass: float) -> str:
    centre = f'<origin xyz="{LENGTH / 2} 0 0"/><mass value="{mass}"/>'
    return f'<inertial>{centre}<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'


def _joint(name: str, parent: str, child: str, at: str, reach: float) -> str:
    return f"""<joint name="{name}" type="revolute"><origin xyz="{at}"/>
<parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/>
<limit lower="{-reach}" upper="{reach}" velocity="2" effort="100"/></joint>"""
