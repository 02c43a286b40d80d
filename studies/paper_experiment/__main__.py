"""Command line: python -m studies.paper_experiment."""

import sys

from studies.paper_experiment.experiment import main

sys.exit(main())
