"""What the robot's file says stands beside the estimate where it says it, and nowhere else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import oed
from oed.commands.configurations import ModelName
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.estimation.calibration import Calibration
from oed.estimation.file_values import file_values, total_mass
from oed.robot import Robot, imi_scara, load_robot
from oed.robot.builtin import IMI_BASE_PARAMETERS

FRICTION = (2.0, 3.0)  # [N m, N m s/rad] of every joint
CART, ARM = 7.0, 2.0  # [kg]
LIFT = f"""<robot name="lift"><link name="base"/>
<link name="cart"><inertial><mass value="{CART}"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="arm"><inertial><origin xyz="0.3 0 0"/><mass value="{ARM}"/>
<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="up" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="2" effort="900"/></joint>
<joint name="turn" type="revolute"><parent link="cart"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="5" effort="90"/></joint></robot>"""


def identified(robot: Robot, *, heavier: float = 1.0, model: ModelName = "standard") -> Calibration:
    """From recordings of an arm whose links are all heavier than in its file by a factor."""
    rng = np.random.default_rng(5)
    truth = np.concatenate([heavier * robot.parameters, np.tile(FRICTION, robot.n)])
    motions = [_motion(rng) for _ in range(2)]
    torque = build_model("standard", robot)
    return oed.identify(
        oed.DataSet.from_arrays(
            robot,
            t=[m.t for m in motions],
            q=[m.q for m in motions],
            tau=[torque.torque(truth, m) + rng.normal(0, 0.01, m.q.shape) for m in motions],
            roles=["estimation", "validation"],
        ),
        model=model,
    )


def _motion(rng: np.random.Generator) -> Motion:
    t = np.arange(0.0, 20.0, 0.004)
    rates = 2 * np.pi * rng.uniform(0.1, 0.8, (3, 2))
    phases = t[:, None, None] * rates
    return Motion(
        t,
        0.3 * np.sin(phases).sum(axis=1),
        0.3 * (rates * np.cos(phases)).sum(axis=1),
        -0.3 * (rates**2 * np.sin(phases)).sum(axis=1),
    )


def test_the_file_s_combinations_stand_beside_the_estimate() -> None:
    calibration = identified(imi_scara(), heavier=1.3)
    told = dict(zip(calibration.estimate.names, file_values(calibration), strict=True))
    # The base parameters that the paper prints of this arm.
    assert [told[n] for n in ("Izz_1", "mx_2", "my_2", "Izz_2")] == pytest.approx(
        IMI_BASE_PARAMETERS
    )
    assert np.isnan([told[n] for n in ("Fc_1", "Fv_1", "Fc_2", "Fv_2")]).all()
    found = dict(zip(calibration.estimate.names, calibration.estimate.parameters, strict=True))
    assert found["Izz_2"] / told["Izz_2"] == pytest.approx(1.3, rel=0.02)


def test_a_combination_with_what_no_file_says_has_no_value_of_the_file() -> None:
    """A rotor that turns about the same axis as its link is seen with it alone."""
    calibration = identified(imi_scara(), model="rotor")
    told = file_values(calibration)
    base = calibration.base
    rotors = [k for k, p in enumerate(calibration.model.parameters) if p.name.startswith("Ia")]
    mixed = [
        k
        for k, c in enumerate(calibration.estimate.columns)
        if (base.regrouping[c][rotors] != 0).any()
    ]
    assert mixed
    assert np.isnan(told[mixed]).all()


def test_the_total_mass_of_an_arm_that_only_turns_is_in_no_torque() -> None:
    mass = total_mass(identified(imi_scara()))
    assert not mass.is_in_torque
    assert (mass.value, mass.interval) == (None, None)
    assert mass.file == pytest.approx(21.0)  # 15 kg and 6 kg


def test_a_lift_carries_the_total_mass_and_tells_it(tmp_path: Path) -> None:
    path = tmp_path / "lift.urdf"
    path.write_text(LIFT, encoding="utf-8")
    mass = total_mass(identified(load_robot(path), heavier=1.3))
    assert mass.is_in_torque
    assert mass.file == pytest.approx(CART + ARM)
    assert mass.value == pytest.approx(1.3 * (CART + ARM), rel=0.01)
    assert mass.interval is not None
    low, high = mass.interval
    assert low < 1.3 * (CART + ARM) < high
    assert high - low < 0.2
