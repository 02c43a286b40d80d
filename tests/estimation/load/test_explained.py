import numpy as np
import pytest

from oed.errors import NoUsableResult
from oed.estimation.load.explained import check_explained


def test_what_is_left_worse_than_by_no_model_is_no_result():
    check_explained(np.array([0.02, 1.1]), ["lift", "turn"])
    with pytest.raises(NoUsableResult, match="leave 412 times the torque of turn"):
        check_explained(np.array([0.02, 412.0]), ["lift", "turn"])
    with pytest.raises(NoUsableResult, match="turn"):
        check_explained(np.array([0.02, np.nan]), ["lift", "turn"])
