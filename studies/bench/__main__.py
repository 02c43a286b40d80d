"""`python -m studies.bench`."""

from oed.process_end import RESUMES, leave
from studies.bench.study import main

if __name__ == "__main__":
    leave(main, "studies.bench", RESUMES)
