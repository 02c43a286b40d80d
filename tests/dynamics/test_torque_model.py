"""The torque model: one shape for all effects, numbers and symbols alike."""

from pathlib import Path

import casadi
import numpy as np
import pytest

from oed.dynamics.effects import Coulomb, MotorCoupling, RotorInertia
from oed.dynamics.models import MODELS, build_model
from oed.dynamics.motion import random_motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import imi_scara, load_robot
from oed.robot.robot import PINION_RADIUS
from tests.paths import example_robot


def _full_model() -> TorqueModel:
    robot = load_robot(example_robot("ur_description/urdf/ur5_robot.urdf"))
    coupling = MotorCoupling((4, 5), (1.0, 0.5), width=0.1)
    return build_model("offset", robot, sign_width=0.1).with_effects(coupling)


def test_symbols_and_numbers_give_the_same_columns() -> None:
    model = _full_model()
    motion = random_motion(model.robot, 5, np.random.default_rng(10))
    q, dq, ddq = (casadi.SX.sym(name, 6) for name in ("q", "dq", "ddq"))
    columns = casadi.Function(
        "columns", [q, dq, ddq], [model.symbolic_columns(q, dq, ddq, sign_width=0.0)]
    )
    for k, numeric in enumerate(model.columns(motion)):
        symbolic = np.asarray(columns(motion.q[k], motion.dq[k], motion.ddq[k]))
        assert numeric == pytest.approx(symbolic, abs=1e-12)


def test_rows_are_sample_major() -> None:
    model = TorqueModel.standard(imi_scara())
    motion = random_motion(model.robot, 4, np.random.default_rng(11))
    regressor = model.regressor(motion)
    assert regressor.shape == (8, 24)
    assert np.array_equal(regressor[5], model.columns(motion)[2, 1])


def test_torque_is_columns_times_parameters_effect_by_effect() -> None:
    model = TorqueModel.standard(imi_scara()).with_effects(RotorInertia(1))
    motion = random_motion(model.robot, 6, np.random.default_rng(12))
    parameters = np.zeros(len(model.parameters))
    parameters[[p.name for p in model.parameters].index("Ia_2")] = 0.3
    torque = model.torque(parameters, motion)
    assert torque[:, 0] == pytest.approx(0.0)
    assert torque[:, 1] == pytest.approx(0.3 * motion.ddq[:, 1])


def test_every_parameter_has_its_own_name() -> None:
    names = [p.name for p in _full_model().parameters]
    assert len(set(names)) == len(names)


def test_a_coupled_motor_acts_on_both_joints_with_its_ratios() -> None:
    robot = imi_scara()
    coupling = TorqueModel(robot, (MotorCoupling((0, 1), (1.0, 2.0)),))
    motion = random_motion(robot, 8, np.random.default_rng(13))
    inertia, viscous, coulomb = 0.2, 0.5, 0.7
    speed = motion.dq @ [1.0, 2.0]
    motor = inertia * motion.ddq @ [1.0, 2.0] + viscous * speed + coulomb * np.sign(speed)
    torque = coupling.torque(np.array([inertia, viscous, coulomb]), motion)
    assert torque == pytest.approx(np.outer(motor, [1.0, 2.0]))


def test_an_unknown_model_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ValueError, match="standard"):
        build_model("stanadrd", imi_scara())
    assert set(MODELS) == {"standard", "rotor", "offset"}


def slide_model(folder: Path) -> TorqueModel:
    (folder / "slide.urdf").write_text("""<robot name="s"><link name="a"/>
<link name="b"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="slide" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" velocity="1" effort="9"/></joint></robot>""")
    return build_model("rotor", load_robot(folder / "slide.urdf"), sign_width=0.1)


def test_units_at_a_slide_are_those_of_a_force(tmp_path: Path) -> None:
    model = slide_model(tmp_path)
    units = {parameter.name: parameter.unit for parameter in model.parameters}
    friction = {name: units[name] for name in ("Fc_1", "Fv_1", "Ia_1")}
    assert friction == {"Fc_1": "N", "Fv_1": "N s/m", "Ia_1": "kg"}
    assert units["Ixx_1"] == "kg m^2"
    assert {p.unit for p in TorqueModel.standard(imi_scara()).parameters} >= {"N m", "N m s/rad"}


def test_friction_of_a_slide_turns_over_metres_per_second_not_radians(tmp_path: Path) -> None:
    # 0.02 m/s is a usual speed of a slide: over that width its friction was taken for viscous.
    slide, turning = slide_model(tmp_path), build_model("rotor", imi_scara(), sign_width=0.1)
    widths = [e.width for m in (slide, turning) for e in m.effects if isinstance(e, Coulomb)]
    assert widths == pytest.approx([0.1 * PINION_RADIUS, 0.1, 0.1])
