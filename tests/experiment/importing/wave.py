"""A motion of two joints for tests of what is concluded from a log."""

import numpy as np


def wave(t, scale=1.0):
    return scale * np.column_stack([np.sin(2 * t), 0.7 * np.cos(3 * t)])
