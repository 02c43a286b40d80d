"""Repetitions in which no row shows noise still are estimated from, by what is left of their torque."""

import io

import numpy as np
import pandas as pd

import oed
from tests.studies.sound_inputs import MANIFEST, recording


def test_joints_whose_repetitions_show_no_noise_are_weighted_by_their_residuals(tmp_path, recwarn):
    (tmp_path / "dataset.toml").write_text(MANIFEST)
    for seed, name in enumerate(("estimation", "validation")):
        log = pd.read_csv(io.StringIO(recording(seed)))
        log[["tau_1", "tau_2"]] = log[["q_1", "q_2"]]  # no row of which tells noise from direction
        log.to_csv(tmp_path / f"{name}.csv", index=False)
    found = oed.identify(tmp_path)
    assert found.baseline is None
    variances = found.estimate.joint_variances
    left = np.mean(found.estimate.residual**2, axis=0)
    assert np.isfinite(found.estimate.parameters).all()
    np.testing.assert_allclose(variances, left, rtol=0.5)
    assert not [w for w in recwarn if issubclass(w.category, RuntimeWarning)]
