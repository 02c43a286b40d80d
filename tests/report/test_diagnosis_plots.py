"""Figures of a diagnosis can be read where they are shown."""

from io import BytesIO

import numpy as np
import pytest
from matplotlib.text import Text

from oed.report.diagnosis_plots import Curve, CurvePanel, plot_contributions, plot_proof

SMALLEST = 9.0  # [px] letters that can be read without a glass
# [px] that a page leaves for a figure, of a window of 400 and of 1280.
SHOWN = {True: 375, False: 790}


def figures(narrow):
    errors = np.ones((7, 3))
    names = [f"joint {k}" for k in range(1, 8)]
    roles = {"estimation": (errors, errors), "validation": (errors, errors)}
    curve = Curve(np.arange(3.0), np.arange(3.0), np.ones(3))
    title = "joint 2: torque that depends on its velocity and the position of joint 1"
    panel = CurvePanel(title, "N m", "position of joint 1 [rad]", True, curve, curve)
    return (
        plot_proof(roles, np.ones(7), names, ["N m"] * 7, narrow=narrow),
        plot_contributions([panel] * 7, narrow=narrow),
    )


@pytest.mark.parametrize("narrow", [False, True])
def test_letters_are_large_enough_for_the_screen_and_no_title_leaves_its_panel(narrow):
    for figure in figures(narrow):
        width = figure.get_size_inches()[0]
        letters = [text for text in figure.findobj(Text) if text.get_text()]
        least = min(float(text.get_fontsize()) for text in letters)
        assert least / 72 / width * SHOWN[narrow] >= SMALLEST
        assert len(figure.axes) == 7
        figure.savefig(BytesIO())  # lays it out
        for panel in figure.axes:
            title = panel._left_title.get_window_extent()
            assert title.x1 <= figure.bbox.x1
            others = [other for other in figure.axes if other is not panel]
            assert not any(title.overlaps(other.bbox) for other in others)
