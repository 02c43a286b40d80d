"""Inertials that fill a file are told from those that someone computed or weighed."""

import dataclasses

import numpy as np
import pytest

from oed.robot import load_robot
from oed.robot.inertia import parameters_from_pseudo_inertia
from oed.robot.placeholder_inertia import placeholder_reasons
from oed.robot.possible_inertia import InertiaFault
from tests.estimation.feasible.cases import random_tree
from tests.paths import example_robot


def robot_of(*bodies):
    tree = random_tree(len(bodies), np.random.default_rng(3), branching=False)
    return tree.with_parameters(np.concatenate(bodies))


def body(mass, spreads, centre=(0.0, 0.02, 0.1)):
    """Mass [kg], standard deviations of its distribution along the axes [m], centre [m]."""
    y = np.append(centre, 1.0)
    pseudo = mass * np.outer(y, y)
    pseudo[:3, :3] += mass * np.diag(np.square(spreads))
    return parameters_from_pseudo_inertia(pseudo)


REAL = (body(3.0, (0.05, 0.06, 0.1)), body(2.0, (0.03, 0.04, 0.09)), body(1.0, (0.02, 0.03, 0.04)))


@pytest.mark.parametrize("name", ["ur5_robot", "ur10_robot", "ur3_robot"])
def test_makers_numbers_are_taken(name):
    assert placeholder_reasons(load_robot(example_robot(f"ur_description/urdf/{name}.urdf"))) == ()


def test_bodies_of_different_shapes_are_taken():
    assert placeholder_reasons(robot_of(*REAL)) == ()


@pytest.mark.parametrize(
    ("bodies", "why"),
    [
        ((body(1.0, (1.0, 1.0, 1.0)),) * 3, "spread over 1 m"),
        ((body(3.0, (0.1, 0.1, 0.1)), body(2.0, (0.1, 0.1, 0.1)), REAL[2]), "2 of 3 links"),
        ((REAL[0],) * 3, "all 3 links have the same"),
        ((body(5.0, (1e-3, 2e-3, 3e-3)), *REAL[1:]), "denser than any matter"),
        ((np.zeros(10), *REAL[1:]), "no mass is given for link_1"),
        ((body(1.0, (0.0, 0.1, 0.1)), *REAL[1:]), "no body with volume"),
    ],
)
def test_fillings_are_named(bodies, why):
    assert any(why in reason for reason in placeholder_reasons(robot_of(*bodies)))


def test_a_lead_weight_is_matter_and_a_gramme_for_a_kilogramme_is_not():
    # A ball of radius r has variances r^2 / 5: lead at 11,340 kg/m^3.
    radius = (3 / (4 * np.pi * 11340.0)) ** (1 / 3)
    lead = body(1.0, np.array([1.0, 1.001, 1.002]) * radius / np.sqrt(5))
    assert placeholder_reasons(robot_of(lead, *REAL[1:])) == ()
    heavier = lead * np.array([3.0] + [3.0] * 3 + [3.0] * 6)  # the same shape, 34,000 kg/m^3
    assert "denser" in placeholder_reasons(robot_of(heavier, *REAL[1:]))[0]


def test_what_the_loader_replaced_is_no_makers_number():
    robot = load_robot(example_robot("ur_description/urdf/ur5_robot.urdf"))
    fault = InertiaFault("link_2", "link_2 has a negative moment", True)
    assert placeholder_reasons(dataclasses.replace(robot, inertia_faults=(fault,))) == (fault.text,)
