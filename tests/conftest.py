"""What holds for every test: shape checks on, figures off screen, one BLAS thread."""

import os
from pathlib import Path

# Read once, when a numerical library loads: so before any import that may load one.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import jaxtyping
import matplotlib as mpl
import pytest
from hypothesis import settings
from jaxtyping import install_import_hook

mpl.use("Agg")

# Every shape and type annotation of the package is enforced while the tests run, but for those of
# scalars, which may be anything: their algebra is called by the million.
UNCHECKED = "oed.dynamics.scalars"
ROOT = Path(__file__).resolve().parents[1]
modules = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for path in (ROOT / "oed").rglob("*.py")
    if path.stem != "__init__"
}
install_import_hook(sorted(modules - {UNCHECKED}), "beartype.beartype")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Shapes are checked but in whole searches, which would spend most of their time on that.

    They call the same functions a hundred thousand times: the tests of these, and one whole search
    in `studies/test_close_loop.py`, check all that there is to check.
    """
    unchecked = item.get_closest_marker("whole_search") is not None
    jaxtyping.config.update("jaxtyping_disable", unchecked)


# The same examples in every run: a failure seen once can be seen again. No deadline: the
# machine's load is not the code's fault.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")
