"""Shapes: places from 0 to 1, values, and what a step of the one is of the other."""

import numpy as np
import pytest

from oed.dynamics.effects.entry import Shape

SHAPES = (
    Shape("speed", "rad/s", 0.003, 1.0, "log", 14, 0.05),
    Shape("angle", "rad", -1.0, 3.0, "linear", 5, 0.0),
    Shape("delay", "s", -0.05, 0.12, "signed log", 24, 3e-3, linear_below=2e-4),
)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s.scale)
def test_a_value_comes_back_from_its_place(shape: Shape) -> None:
    for place in np.linspace(0, 1, 11):
        assert shape.place_of(shape.at(float(place))) == pytest.approx(place, abs=1e-12)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s.scale)
def test_slope_is_the_change_of_the_value(shape: Shape) -> None:
    step = 1e-6
    for place in (0.1, 0.3, 0.5, 0.9):
        difference = (shape.at(place + step) - shape.at(place - step)) / (2 * step)
        assert shape.slope_at(shape.at(place)) == pytest.approx(difference, rel=1e-8)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s.scale)
def test_places_outside_are_brought_to_the_bounds(shape: Shape) -> None:
    assert shape.at(-0.5) == pytest.approx(shape.lower)
    assert shape.at(1.5) == pytest.approx(shape.upper)


def test_a_scale_with_signs_is_as_fine_for_small_sizes_of_either_sign() -> None:
    grid = np.array(SHAPES[2].grid)
    assert (np.diff(grid) > 0).all()
    ratios = [abs(g[1:] / g[:-1]) for g in (grid[grid > 1e-3], grid[grid < -1e-3][::-1])]
    assert np.concatenate(ratios) == pytest.approx(ratios[0][-1], rel=0.02)  # as a log scale has it
    near = np.diff(grid[np.abs(grid) < 1e-4])
    assert (near < 2e-4).all()


def test_choices_are_whole_numbers() -> None:
    clock = Shape("clock", "1", 0.0, 1.0, "choice", 2, 0.0)
    assert {clock.at(float(p)) for p in np.linspace(0, 1, 9)} == {0.0, 1.0}


def test_a_scale_with_signs_needs_a_size_below_which_it_is_linear() -> None:
    with pytest.raises(ValueError, match="linear_below"):
        Shape("delay", "s", -0.1, 0.1, "signed log", 24, 0.0)
