"""Meshes are found by paths, by packages beside the robot's file, and where the user says."""

from __future__ import annotations

from pathlib import Path

import pytest

from oed.design.meshes import find_mesh
from oed.robot.packages import read_packages
from tests.design.tetrahedron import TETRAHEDRON, write_binary_stl


def test_finds_by_relative_and_absolute_path(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    mesh = write_binary_stl(TETRAHEDRON, tmp_path / "meshes" / "t.stl")
    source = tmp_path / "r.urdf"
    for name in ("meshes/t.stl", str(mesh), f"file://{mesh}"):
        found = find_mesh(name, source)
        assert found is not None, name
        assert found.samefile(mesh)
    assert find_mesh("meshes/absent.stl", source) is None
    assert find_mesh("meshes", source) is None
    assert find_mesh("", source) is None


@pytest.mark.parametrize("scheme", ["package", "model"])
def test_finds_a_package_by_its_folder(scheme: str, tmp_path: Path) -> None:
    inside = tmp_path / "arm_description" / "meshes"
    inside.mkdir(parents=True)
    mesh = write_binary_stl(TETRAHEDRON, inside / "t.stl")
    name = f"{scheme}://arm_description/meshes/t.stl"
    # The robot's file within the package, and one in a package beside it.
    for source in (
        tmp_path / "arm_description" / "urdf" / "r.urdf",
        tmp_path / "other" / "r.urdf",
    ):
        assert find_mesh(name, source) == mesh
    assert find_mesh(f"{scheme}://other_description/meshes/t.stl", tmp_path / "r.urdf") is None


def test_a_package_is_found_where_the_user_or_the_workspace_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name, source = "package://arm_description/meshes/t.stl", tmp_path / "here" / "r.urdf"
    source.parent.mkdir()
    assert find_mesh(name, source) is None
    found = {}
    for root in ("named", "ros/arm_description", "ament/share/arm_description"):
        mesh = tmp_path / "elsewhere" / root / "meshes" / "t.stl"
        mesh.parent.mkdir(parents=True)
        mesh.touch()
        found[root.partition("/")[0]] = mesh
    assert find_mesh(name, source) is None
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "elsewhere" / "ament"))
    assert find_mesh(name, source) == found["ament"]
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "elsewhere" / "ros"))
    assert find_mesh(name, source) == found["ros"]
    named = read_packages([f"arm_description={tmp_path / 'elsewhere' / 'named'}"])
    assert find_mesh(name, source, named) == found["named"]


@pytest.mark.parametrize(
    ("word", "told"), [("arm", "NAME=DIR"), ("=x", "NAME=DIR"), ("arm=/gone", "no such folder")]
)
def test_a_package_that_is_not_named_rightly_is_refused(word: str, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        read_packages([word])


def test_finds_a_package_by_its_description(tmp_path: Path) -> None:
    checkout = tmp_path / "some-checkout"
    (checkout / "meshes").mkdir(parents=True)
    mesh = write_binary_stl(TETRAHEDRON, checkout / "meshes" / "t.stl")
    source = checkout / "urdf" / "r.urdf"
    assert find_mesh("package://arm_description/meshes/t.stl", source) is None
    (checkout / "package.xml").write_text("<package><name> arm_description </name></package>")
    assert find_mesh("package://arm_description/meshes/t.stl", source) == mesh
    assert find_mesh("package://arm/meshes/t.stl", source) is None
