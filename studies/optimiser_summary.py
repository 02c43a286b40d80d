"""What the runs of `studies.compare_optimisers` say: one table a question, and a figure."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from oed.design.optimisers.target_hits import expected_cost, first_hit, hit_curve
from oed.report.comparison_plots import HitPanel, plot_target_hits
from oed.report.json_file import write_atomically
from oed.report.style import save_figure
from oed.report.table import Row, markdown_table, number_of, read_csv
from studies.data_folders import REPOSITORY
from studies.optimiser_comparison import LEVEL, MATTERS, Cell, cells_of, compare, ranked

DEFAULT = "interior-point"  # of the command
WITHOUT_GRADIENT = ("genetic", "cma-es", "random")
NAMES = {"paper": "the paper's arm of two joints", "panda": "a Panda of seven joints"}
# What an earlier state of this study reached in 2.5 CPU seconds, the best of 30 seeds.
EARLIER = {("paper", "J_k"): 5.2705, ("paper", "J_d"): 19.92238, ("panda", "J_d"): 193.998}
BOUND_DESIGNS = REPOSITORY / "results/optimality_bound/designs.csv"
SAME_CLASS = "fourier, 5 harmonics, 10 s"
TRAJECTORIES = REPOSITORY / "results/compare_trajectories/runs.csv"
LOSSES = (0.05, 0.01)
# Of the figure: from 1 % to three times worse than the best known.
CURVE_LOSSES = np.geomspace(0.01, 3.0, 25)
CURVE_POINTS = 200
SOONEST = 0.02  # [s] of CPU time where the figure begins: a few evaluations
HOPS = re.compile(r"\b(\d+) hops?\b")
SAID = """\
- One optimiser is *ahead* of another at a budget if the interval of its gain, seed by seed, lies wholly above 1;
  *as good* if it lies within {matters:.0%} of 1; *not told apart* otherwise. The gain is the ratio of J_k, or of the
  information about every parameter, 10^(difference of J_d / base parameters), in the geometric mean. Intervals are
  those of Student's t, {level:.0%} for all pairs of a budget together (Bonferroni). "The best" below has the best mean; that
  ranking is refuted for each rival that is not told apart from it.
- That {default}, the default of the command, is beaten by none at any budget: refuted where another is ahead of it.
- That gradients pay: refuted where the best optimiser without them is ahead of the best with them, not shown where
  these two are not told apart.
"""
