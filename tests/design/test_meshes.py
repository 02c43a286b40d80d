"""Meshes that Drake cannot read are made readable, and nobody stumbles over the others."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from jaxtyping import Float
from numpy import ndarray
from pydrake.geometry import ReadObjToTriangleSurfaceMesh

from oed.design.meshes import load_triangles, with_readable_meshes, write_obj
from tests.design.tetrahedron import TETRAHEDRON, VOLUME, robot_text, write_binary_stl


def write_ascii_stl(triangles: ndarray, path: Path) -> Path:
    lines = ["solid s"]
    for triangle in triangles:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x} {y} {z}" for x, y, z in triangle]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid s", ""]))
    return path


def corner_sets(triangles: Float[ndarray, "triangles 3 3"]) -> set[frozenset]:
    """The triangles, whatever their order and the order of their corners."""
    return {frozenset(map(tuple, np.round(t, 9).tolist())) for t in triangles}


def volume(triangles: ndarray) -> float:
    """By the divergence theorem; positive where the faces wind outwards."""
    return float(np.linalg.det(triangles).sum() / 6)


def shape(kind: str, file: str) -> str:
    return f'<{kind}><geometry><mesh filename="{file}" scale="2 2 2"/></geometry></{kind}>'


def parsed(text: str) -> ElementTree.Element:
    return ElementTree.fromstring(text)  # noqa: S314  # written by these tests


def read_back(text: str) -> list[Path]:
    return [Path(mesh.get("filename", "")) for mesh in parsed(text).iter("mesh")]


def test_binary_stl_gives_its_corners(tmp_path: Path) -> None:
    found = load_triangles(write_binary_stl(TETRAHEDRON, tmp_path / "t.STL"))
    np.testing.assert_array_equal(found, TETRAHEDRON)
    assert volume(found) == pytest.approx(VOLUME)


def test_a_binary_stl_may_call_itself_solid(tmp_path: Path) -> None:
    path = write_binary_stl(TETRAHEDRON, tmp_path / "t.stl", header=b"solid made by a CAD program")
    np.testing.assert_array_equal(load_triangles(path), TETRAHEDRON)


def test_ascii_stl_gives_the_same_triangles(tmp_path: Path) -> None:
    found = load_triangles(write_ascii_stl(TETRAHEDRON, tmp_path / "t.stl"))
    assert corner_sets(found) == corner_sets(TETRAHEDRON)
    assert volume(found) == pytest.approx(VOLUME)


@pytest.mark.parametrize("content", [b"", b"no mesh at all", b"x" * 200, bytes(84)])
@pytest.mark.parametrize("suffix", [".stl", ".dae"])
def test_a_file_without_a_mesh_is_refused_by_name(
    content: bytes, suffix: str, tmp_path: Path
) -> None:
    path = tmp_path / f"broken{suffix}"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=f"broken{suffix}"):
        load_triangles(path)


def test_obj_counts_from_one_and_holds_each_corner_once(tmp_path: Path) -> None:
    write_obj(TETRAHEDRON, tmp_path / "t.obj")
    lines = [line.split() for line in (tmp_path / "t.obj").read_text().splitlines()]
    indices = {int(i) for line in lines if line[0] == "f" for i in line[1:]}
    assert indices == {1, 2, 3, 4}
    assert sum(line[0] == "v" for line in lines) == 4


def test_drake_reads_the_obj_as_the_same_solid(tmp_path: Path) -> None:
    shifted = TETRAHEDRON + np.array([0.1, -0.2, 1 / 3])
    write_obj(shifted, tmp_path / "t.obj")
    mesh = ReadObjToTriangleSurfaceMesh(tmp_path / "t.obj")
    found = np.array(
        [
            [mesh.vertex(mesh.element(i).vertex(k)) for k in range(3)]
            for i in range(mesh.num_triangles())
        ]
    )
    assert volume(found) == pytest.approx(VOLUME, rel=1e-5)
    np.testing.assert_allclose(found, shifted, atol=1e-6)


def test_missing_and_broken_meshes_are_named_and_left_out(tmp_path: Path) -> None:
    write_binary_stl(TETRAHEDRON, tmp_path / "good.stl")
    (tmp_path / "broken.stl").write_bytes(b"?")
    (tmp_path / "scratch").mkdir()
    box = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    text = robot_text(
        shape("visual", "good.stl"),
        shape("visual", "broken.stl"),
        shape("collision", "package://nobody/absent.dae"),
        box,
    )
    found = with_readable_meshes(text, tmp_path / "r.urdf", tmp_path / "scratch")
    assert found.missing == ("broken.stl", "package://nobody/absent.dae")
    link = parsed(found.text).find("link")
    assert link is not None
    assert len(link.findall("visual")) == 1
    assert len(link.findall("collision")) == 1
    assert link.find("collision/geometry/box") is not None


def test_what_drake_reads_stays_the_file_it_is(tmp_path: Path) -> None:
    write_obj(TETRAHEDRON, tmp_path / "t.obj")
    (tmp_path / "scratch").mkdir()
    text = robot_text(shape("visual", "t.obj"), shape("collision", "t.obj"))
    found = with_readable_meshes(text, tmp_path / "r.urdf", tmp_path / "scratch")
    assert all(path.samefile(tmp_path / "t.obj") for path in read_back(found.text))
    assert not list((tmp_path / "scratch").iterdir())


def test_is_converted_once_a_use_and_keeps_its_scale(tmp_path: Path) -> None:
    write_binary_stl(TETRAHEDRON, tmp_path / "t.stl")
    (tmp_path / "scratch").mkdir()
    text = robot_text(*[shape(kind, "t.stl") for kind in ("visual", "collision") * 2])
    found = with_readable_meshes(text, tmp_path / "r.urdf", tmp_path / "scratch")
    assert len(list((tmp_path / "scratch").iterdir())) == 2
    assert 'scale="2 2 2"' in found.text


def test_collisions_get_the_convex_hull_and_pictures_the_mesh(tmp_path: Path) -> None:
    # A cube of side 2 with a pit: its top face is a pyramid that points to the centre.
    top = np.array([[-1.0, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])
    bottom = top * [1, 1, -1]
    quads = [bottom[::-1], *([bottom[i], bottom[i - 3], top[i - 3], top[i]] for i in range(4))]
    triangles = [np.array([q[0], q[i], q[i + 1]]) for q in quads for i in (1, 2)]
    triangles += [np.array([top[i], top[i - 3], np.zeros(3)]) for i in range(4)]
    pitted = np.array(triangles)
    assert volume(pitted) == pytest.approx(8 - 4 / 3)
    write_binary_stl(pitted, tmp_path / "cube.stl")
    (tmp_path / "scratch").mkdir()
    text = robot_text(shape("visual", "cube.stl"), shape("collision", "cube.stl"))
    found = with_readable_meshes(text, tmp_path / "r.urdf", tmp_path / "scratch")
    drawn, hull = (load_triangles(path) for path in read_back(found.text))
    assert volume(drawn) == pytest.approx(8 - 4 / 3)
    assert {tuple(x) for x in hull.reshape(-1, 3)} == {tuple(x) for x in [*top, *bottom]}
    # The hull's faces may wind either way: tetrahedra about the centre, inside a convex solid.
    assert np.abs(np.linalg.det(hull)).sum() / 6 == pytest.approx(8.0)


def test_a_flat_mesh_has_no_hull_and_stays_itself(tmp_path: Path) -> None:
    flat = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    write_binary_stl(flat, tmp_path / "flat.stl")
    (tmp_path / "scratch").mkdir()
    found = with_readable_meshes(
        robot_text(shape("collision", "flat.stl")), tmp_path / "r.urdf", tmp_path / "scratch"
    )
    assert corner_sets(load_triangles(read_back(found.text)[0])) == corner_sets(flat)


def test_a_drawn_mesh_keeps_its_shape_to_half_a_thousandth_of_its_extent(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    corners = rng.uniform(-0.2, 0.2, (300, 1, 3)) + rng.normal(0, 0.02, (300, 3, 3))
    speck = np.full((1, 3, 3), 0.1) + 1e-7 * np.eye(3)  # no pixel of any picture
    write_binary_stl(np.concatenate([corners, speck]), tmp_path / "rough.stl")
    (tmp_path / "scratch").mkdir()
    text = robot_text(shape("visual", "rough.stl"))
    found = with_readable_meshes(text, tmp_path / "r.urdf", tmp_path / "scratch")
    drawn = load_triangles(read_back(found.text)[0])
    assert len(drawn) == len(corners)
    off = np.abs(drawn - corners).max()
    extent = np.ptp(corners.reshape(-1, 3), axis=0).max()
    assert 0 < off <= extent / 1000 / 2 + 1e-6  # single precision of the file
