"""`python -m studies.estimators`."""

from oed.process_end import RESUMES, leave
from studies.estimators.study import main

if __name__ == "__main__":
    leave(main, "studies.estimators", RESUMES)
