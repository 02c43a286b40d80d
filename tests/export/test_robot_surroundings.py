"""A log and a robot that names other files: what is exported shows what the robot's own file shows."""

from __future__ import annotations

import shutil
from pathlib import Path

import mujoco
import pytest

from oed.experiment.read_dataset import read_dataset
from oed.experiment.write_dataset import write_dataset
from oed.export.model_file import write_model
from oed.robot import load_robot
from oed.robot.xml_tree import parse_xml
from tests.design.test_meshes import TETRAHEDRON, write_binary_stl
from tests.experiment.importing.laboratory_logs import JOINTS, echo_csv, simulate, write_urdf
from tests.export.every_effect import model_with
from tests.running import oed

OBJ = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
SDF_LINK = """\
<joint name="{name}" type="revolute">
  <parent>{parent}</parent><child>{name}_link</child>
  <axis><xyz>0 1 0</xyz><limit><lower>-2.5</lower><upper>2.5</upper></limit></axis>
</joint>
<link name="{name}_link">
  <pose relative_to="{parent}">0 0 -0.3 0 0 0</pose>
  <inertial><pose>0.02 0 -0.15 0 0 0</pose><mass>{mass}</mass>
    <inertia><ixx>.02</ixx><iyy>.02</iyy><izz>.01</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia>
  </inertial>
  <visual name="look"><geometry><mesh><uri>meshes/link.obj</uri></mesh></geometry></visual>
</link>
"""
MJCF_BODY = """\
<body name="{name}_link" pos="0 0 -0.3">
  <joint name="{name}" type="hinge" axis="0 1 0" range="-2.5 2.5"/>
  <inertial pos="0.02 0 -0.15" mass="{mass}" diaginertia="0.02 0.02 0.01"/>
  <geom type="mesh" mesh="link" contype="0" conaffinity="0"/>
"""
MASSES = (3.0, 2.0, 1.0)


def _urdf(folder: Path, filename: str) -> Path:
    file = write_urdf(folder / "arm.urdf")
    shape = f'<visual><geometry><mesh filename="{filename}"/></geometry></visual></link>'
    file.write_text(file.read_text().replace("</inertial></link>", f"</inertial>{shape}"))
    (folder / "meshes").mkdir()
    write_binary_stl(TETRAHEDRON, folder / "meshes" / "link.stl")
    return file


def relative_urdf(folder: Path) -> Path:
    return _urdf(folder, "meshes/link.stl")


def urdf_of_a_package(folder: Path) -> Path:
    (folder / "package.xml").write_text("<package><name>my_arm</name></package>")
    return _urdf(folder, "package://my_arm/meshes/link.stl")


def sdf(folder: Path) -> Path:
    parents = ("base", *(f"{name}_link" for name in JOINTS))
    links = "".join(
        SDF_LINK.format(name=name, parent=parent, mass=mass)
        for name, parent, mass in zip(JOINTS, parents, MASSES, strict=False)
    )
    file, meshes = folder / "arm.sdf", folder / "meshes"
    file.write_text(
        f'<sdf version="1.7"><model name="arm"><link name="base"/>{links}</model></sdf>'
    )
    meshes.mkdir()
    (meshes / "link.obj").write_text(OBJ)
    return file


def mjcf_with_an_include(folder: Path) -> Path:
    bodies = "".join(MJCF_BODY.format(name=n, mass=m) for n, m in zip(JOINTS, MASSES, strict=True))
    (folder / "chain.xml").write_text(
        f"<mujoco><worldbody>{bodies}{'</body>' * len(JOINTS)}</worldbody></mujoco>"
    )
    file, meshes = folder / "arm.xml", folder / "meshes"
    file.write_text(
        '<mujoco model="arm"><compiler angle="radian" meshdir="meshes"/>'
        '<asset><mesh name="link" file="link.obj"/></asset><include file="chain.xml"/></mujoco>'
    )
    meshes.mkdir()
    (meshes / "link.obj").write_text(OBJ)
    return file


@pytest.fixture(
    scope="module", params=[relative_urdf, urdf_of_a_package, sdf, mjcf_with_an_include]
)
def laboratory(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot in its surroundings, and beside them a data set that was imported."""
    folder = tmp_path_factory.mktemp("laboratory")
    (folder / "my_arm").mkdir()
    file = request.param(folder / "my_arm")
    log = echo_csv(simulate(load_robot(file), rows=600), folder)
    assert oed("import", log, "--robot", file, "--out", folder / "set", "--quiet") == 0
    return folder


def shown(out: Path, name: str) -> int:
    """How many meshes a file shows; every one must be there."""
    root = parse_xml((out / name).read_bytes(), name).root
    names = [e.attrib["filename"] for e in root.iter("mesh") if e.get("filename")]
    names += [(uri.text or "") for uri in root.iter("uri")]
    for each in names:
        if "://" not in each:
            assert not Path(each).is_absolute()
            assert (out / each).resolve().is_file()
    return len(names)


def test_every_export_shows_the_meshes(laboratory: Path, tmp_path: Path) -> None:
    model, _ = model_with(robot=read_dataset(laboratory / "set").robot, duration=0.3)
    write_model(model, tmp_path / "in" / "model.json")
    kinds = ("urdf", "sdf", "mjcf")
    assert oed("export", tmp_path / "in", "--to", *kinds, "--out", tmp_path / "out") == 0
    assert shown(tmp_path / "out", "robot.urdf") == len(JOINTS)
    assert shown(tmp_path / "out", "robot.sdf") == len(JOINTS)
    mjmodel = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "robot.xml"))
    assert mjmodel.ngeom == len(JOINTS)
    assert mjmodel.nmesh >= 1


def test_a_data_set_that_is_written_again_knows_them_too(laboratory: Path, tmp_path: Path) -> None:
    dataset = read_dataset(laboratory / "set")
    write_dataset(dataset, tmp_path / "deeper" / "copy")
    again = read_dataset(tmp_path / "deeper" / "copy").robot.description
    assert dataset.robot.description is not None
    assert again is not None
    assert again.place.resolve() == dataset.robot.description.place.resolve()


def test_the_surroundings_are_named_relative_to_the_data_set(
    laboratory: Path, tmp_path: Path
) -> None:
    text = (laboratory / "set" / "dataset.toml").read_text()
    assert 'robot_from = "../my_arm/arm.' in text
    assert str(laboratory) not in text
    # So both may be moved together.
    shutil.copytree(laboratory, tmp_path / "moved")
    moved = read_dataset(tmp_path / "moved" / "set").robot.description
    assert moved is not None
    assert moved.place.resolve().parent == (tmp_path / "moved" / "my_arm").resolve()


def test_a_robot_that_names_no_file_needs_no_surroundings(tmp_path: Path) -> None:
    file = write_urdf(tmp_path / "arm.urdf")
    log = echo_csv(simulate(load_robot(file), rows=600), tmp_path)
    assert oed("import", log, "--robot", file, "--out", tmp_path / "set", "--quiet") == 0
    assert "robot_from" not in (tmp_path / "set" / "dataset.toml").read_text()
