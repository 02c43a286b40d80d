"""`python -m studies.public_arms`."""

from oed.process_end import RESUMES, leave
from studies.public_arms.study import main

if __name__ == "__main__":
    leave(main, "studies.public_arms", RESUMES)
