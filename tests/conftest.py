"""What holds for every test: shape checks on, figures off screen, one BLAS thread."""

import os

# Read once, when a numerical library loads: so before any import that may load one.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import matplotlib as mpl
from hypothesis import settings
from jaxtyping import install_import_hook

mpl.use("Agg")

# Every shape and type annotation of the package is enforced while the tests run.
install_import_hook("oed", "beartype.beartype")

# The same examples in every run: a failure seen once can be seen again. No deadline: the
# machine's load is not the code's fault.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")
