"""Where the tests find what is not written by them."""

import sysconfig
from pathlib import Path

import pytest

REPO = Path(__file__).resolve().parent.parent
# Recordings are too large to commit: they lie beside the checkout where there are any.
SHARED_DATA = REPO.parent / "shared" / "data"
SHARED_CASES = REPO.parent / "shared" / "cases"
SHARED_LOGS = REPO.parent / "shared" / "logs"

needs_shared_data = pytest.mark.skipif(
    not SHARED_DATA.is_dir(),
    reason="the measured recordings (../shared/data, beside the checkout) are not on this machine",
)

needs_shared_cases = pytest.mark.skipif(
    not SHARED_CASES.is_dir(),
    reason="the small cases (../shared/cases, beside the checkout) are not on this machine",
)

needs_shared_logs = pytest.mark.skipif(
    not SHARED_LOGS.is_dir(),
    reason="the recorded bags (../shared/logs, beside the checkout) are not on this machine",
)


def example_robot(name: str) -> Path:
    """Path of a URDF of the package example-robot-data, such as "panda_description/urdf/panda.urdf"."""
    robots = Path(sysconfig.get_path("purelib"), "cmeel.prefix/share/example-robot-data/robots")
    path = robots / name
    assert path.is_file(), f"example-robot-data has no {name}"
    return path
