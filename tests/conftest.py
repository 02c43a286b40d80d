"""What holds for every test: shape checks on, figures off screen, one BLAS thread."""

import os
from pathlib import Path

# Read once, when a numerical library loads: so before any import that may load one.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import matplotlib as mpl
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

# The same examples in every run: a failure seen once can be seen again. No deadline: the
# machine's load is not the code's fault.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")
