"""Command line: python -m studies.paper_experiment."""

from oed.process_end import RESUMES, leave
from studies.paper_experiment.experiment import main

leave(main, "studies.paper_experiment", RESUMES)
