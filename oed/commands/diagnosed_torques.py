"""The torque of a diagnosis, before and after, along every recording: for its page."""

from __future__ import annotations

import numpy as np

from oed.diagnosis.diagnose import Diagnosis
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.preparation.settings import ProcessingSettings
from oed.report.torque_charts import RoleTorques, Rows


def diagnosed_torques(
    found: Diagnosis, dataset: DataSet, settings: ProcessingSettings
) -> list[RoleTorques]:
    """Measured torque and that of both models in the analysis band, role by role.

    Args:
        found: The diagnosis.
        dataset: What was diagnosed.
        settings: How it was processed then.
    """
    prepared = found.known.taken_off(prepare(dataset.recordings, settings), found.before.model)
    return [
        RoleTorques(
            errors.role,
            Rows.end_to_end([_rows(found, each) for each in prepared if each.role == errors.role]),
            {"before": errors.before, "after": errors.after},
            found.noise_floor,
        )
        for errors in found.errors
    ]


def _rows(found: Diagnosis, prepared: Prepared) -> Rows:
    """One recording; what the log has not whole is a gap."""
    gap = np.where(prepared.valid, 0.0, np.nan)[:, None]
    models = {"before": found.before, "after": found.after}
    return Rows(
        prepared.t,
        prepared.torque + gap,
        {name: model.torque(prepared) for name, model in models.items()},
    )
