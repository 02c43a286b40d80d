import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from oed.estimation.feasible.feasible_set import (
    FeasibleSet,
    MassRegion,
    equality_rows,
    inequality_rows,
)
from oed.robot.inertia import parameters_from_pseudo_inertia
from tests.estimation.feasible.cases import ur5_model


def point_masses(points, masses):
    homogeneous = np.column_stack([points, np.ones(len(points))])
    return parameters_from_pseudo_inertia(
        np.einsum("k,ki,kj->ij", masses, homogeneous, homogeneous)
    )


def demands_on_first_link(region, body):
    model = ur5_model()
    rows = inequality_rows(FeasibleSet(regions=(region,)), model)
    return rows.matrix[:, :10] @ body - rows.bound


def test_mass_inside_a_box_meets_its_demands():
    rng = np.random.default_rng(1)
    rotation, origin = Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)
    lower, upper = np.array([-0.1, -0.2, 0.0]), np.array([0.1, 0.3, 0.5])
    region = MassRegion.box(0, lower, upper, R_JB=rotation, p_JB=origin)
    points = rng.uniform(lower, upper, (30, 3)) @ rotation.T + origin
    assert np.all(demands_on_first_link(region, point_masses(points, rng.uniform(size=30))) > 0)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_mass_outside_a_box_breaks_a_demand(axis):
    region = MassRegion.box(0, -np.ones(3), np.ones(3))
    outside = np.zeros((1, 3))
    outside[0, axis] = 1.1
    assert demands_on_first_link(region, point_masses(outside, np.ones(1))).min() < -0.05


def test_friction_and_rotors_are_not_negative():
    model = ur5_model()
    names = inequality_rows(FeasibleSet.of(model), model).names
    assert len(names) == 3 * model.robot.n
    assert {"Fc_1 >= 0", "Fv_6 >= 0", "Ia_3 >= 0"} <= set(names)


def test_masses_become_equalities():
    model = ur5_model()
    demands = FeasibleSet.of(model).with_(total_mass=18.0, known_masses={2: 2.5})
    rows = equality_rows(demands, model)
    truth = np.zeros(len(model.parameters))
    truth[:60:10] = 3.0
    truth[20] = 2.5
    assert rows.matrix @ truth == pytest.approx([17.5, 2.5])
    assert rows.bound == pytest.approx([18.0, 2.5])


def test_refuses_demands_that_make_no_sense():
    with pytest.raises(ValueError, match="lower"):
        MassRegion.box(0, np.ones(3), np.zeros(3))
    with pytest.raises(ValueError, match="total mass"):
        FeasibleSet(total_mass=-1.0)
    with pytest.raises(ValueError, match="margin"):
        FeasibleSet(margin=0.0)
    with pytest.raises(ValueError, match="link 9"):
        equality_rows(FeasibleSet(known_masses={9: 1.0}), ur5_model())
