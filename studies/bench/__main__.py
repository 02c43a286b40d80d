"""`python -m studies.bench`."""

from studies.bench.study import main
from studies.interrupt import RESUMES, leave

if __name__ == "__main__":
    leave(main, "studies.bench", RESUMES)
