"""A load that is written down is the same body to every program that reads it."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import yaml
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from oed.export.load_files import write_load
from tests.estimation.load.carrying_arm import CENTRAL, CENTRE, MASS

SHIFT = MASS * (CENTRE @ CENTRE * np.eye(3) - np.outer(CENTRE, CENTRE))
BODY = np.array([MASS, *(MASS * CENTRE), *(CENTRAL + SHIFT)[np.triu_indices(3)]])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("load")
    names = write_load(BODY, "tool0", out)
    assert sorted(names) == sorted(p.name for p in out.iterdir())
    return out


@pytest.mark.parametrize("name", ["load.urdf", "load.sdf", "load.xml"])
def test_drake_reads_the_body(folder, name):
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(folder / name)
    plant.Finalize()
    inertia = plant.GetBodyByName("load").default_spatial_inertia()
    assert inertia.get_mass() == pytest.approx(MASS)
    assert inertia.get_com() == pytest.approx(CENTRE)
    about_origin = inertia.CalcRotationalInertia().CopyToFullMatrix3()
    assert about_origin == pytest.approx(CENTRAL + SHIFT)


def test_pinocchio_reads_the_urdf(folder):
    body = pin.buildModelFromUrdf(str(folder / "load.urdf"), pin.JointModelFreeFlyer()).inertias[1]
    assert body.mass == pytest.approx(MASS)
    assert body.lever == pytest.approx(CENTRE)
    assert body.inertia == pytest.approx(CENTRAL)


def test_mujoco_reads_the_mjcf(folder):
    model = mujoco.MjModel.from_xml_path(str(folder / "load.xml"))
    turned = np.zeros(9)
    mujoco.mju_quat2Mat(turned, model.body_iquat[1])
    axes = turned.reshape(3, 3)
    assert model.body_mass[1] == pytest.approx(MASS)
    assert model.body_ipos[1] == pytest.approx(CENTRE)
    assert axes @ np.diag(model.body_inertia[1]) @ axes.T == pytest.approx(CENTRAL)


def test_urscript_has_moments_before_products(folder):
    line = (folder / "load.script").read_text(encoding="utf-8").strip()
    assert line == (
        "set_target_payload(2, [0.02, -0.01, 0.06], [0.006, 0.005, 0.004, 0.001, 0, -0.0005])"
    ) or line.startswith("set_target_payload(2, [0.02, -0.01, 0.06], [0.006, 0.005, 0.004, 0.001, ")


def test_a_frame_of_any_name_leaves_the_message_readable(tmp_path):
    frame = 'tool: [0] # "x"'
    write_load(BODY, frame, tmp_path)
    message = yaml.safe_load((tmp_path / "load_message.yaml").read_text(encoding="utf-8"))
    assert message["header"]["frame_id"] == frame


def test_the_message_names_the_frame(folder):
    text = (folder / "load_message.yaml").read_text(encoding="utf-8")
    assert 'frame_id: "tool0"' in text
    assert "m: 2\n" in text
    assert "ixy: 0.001" in text
