"""The robot's file of the logs that are imported."""

from pathlib import Path

import pytest

from tests.experiment.importing.laboratory_logs import write_urdf


@pytest.fixture(scope="session")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three joints, as those of `laboratory_logs`."""
    return write_urdf(tmp_path_factory.mktemp("arm") / "arm.urdf")
