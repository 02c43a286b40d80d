"""What holds for every test: shape checks on, figures off screen, one BLAS thread."""

import os
from collections.abc import Iterator
from pathlib import Path

# Read once, when a numerical library loads: those that a plugin has loaded by now are told below.
os.environ.setdefault("OMP_NUM_THREADS", "1")
# Tests run side by side already; those of work on several processes say so.
os.environ.setdefault("OED_PROCESSES", "1")

import matplotlib as mpl
import pytest
from hypothesis import settings
from threadpoolctl import threadpool_limits

from tests.browser import Browser, opened
from tests.shape_checks import begin_anew, check_first_calls

mpl.use("Agg")
threadpool_limits(limits=1)

# Of scalars, which may be anything, nothing is checked: their algebra is called by the million.
UNCHECKED = "oed.dynamics.scalars"
ROOT = Path(__file__).resolve().parents[1]
modules = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for path in (ROOT / "oed").rglob("*.py")
    if path.stem != "__init__"
}
check_first_calls(sorted(modules - {UNCHECKED}))


@pytest.fixture(scope="module", autouse=True)
def _checks() -> None:
    """Shapes are checked at the first calls in every file of tests."""
    begin_anew()


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """One browser for all tests that open a page; they skip where there is none."""
    with opened() as browser:
        yield browser


# The same examples in every run: a failure seen once can be seen again. No deadline: the
# machine's load is not the code's fault.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")
