"""Small arms of spheres and boxes, whose distances are known in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.robot import Robot, load_robot

LENGTH = 0.5  # [m] of each link
TIP = 0.1  # [m] radius of the sphere at the end of the second link
POST = np.array([0.1, 0.75, 0.05])  # centre of a sphere that stands beside the arm
POST_RADIUS = 0.12


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


def arm_and_post(folder: Path, *, post: float = POST_RADIUS, **given) -> Robot:
    """A sphere at the tip of the arm and one beside it; `to_post` is their distance."""
    at = " ".join(map(str, POST))
    tip = sphere(TIP, f"{LENGTH} 0 0")
    return planar_arm(folder, base=sphere(post, at), lower=tip, **given)


def elbow_at(q: Float[ndarray, "*postures 2"]) -> Float[ndarray, "*postures 3"]:
    """Where the elbow is [m]."""
    return LENGTH * np.stack([np.cos(q[..., 0]), np.sin(q[..., 0]), 0.0 * q[..., 0]], axis=-1)


def tip_at(q: Float[ndarray, "*postures 2"]) -> Float[ndarray, "*postures 3"]:
    """Where the tip is [m]."""
    return elbow_at(q) + elbow_at(np.cumsum(q, axis=-1)[..., 1:])


def to_post(q: Float[ndarray, "*postures 2"], post: float = POST_RADIUS) -> ndarray:
    """Distance of the two spheres of `arm_and_post` [m], negative where they overlap."""
    return np.linalg.norm(tip_at(q) - POST, axis=-1) - TIP - post


def _shape(geometry: str, at: str, kind: str) -> str:
    return f'<{kind}><origin xyz="{at}"/><geometry>{geometry}</geometry></{kind}>'


def _inertial(mass: float) -> str:
    centre = f'<origin xyz="{LENGTH / 2} 0 0"/><mass value="{mass}"/>'
    return f'<inertial>{centre}<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'


def _joint(name: str, parent: str, child: str, at: str, reach: float) -> str:
    return f"""<joint name="{name}" type="revolute"><origin xyz="{at}"/>
<parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/>
<limit lower="{-reach}" upper="{reach}" velocity="2" effort="100"/></joint>"""
