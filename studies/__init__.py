"""One thin script per question: a frozen configuration, run to rows, write to results/.

The method lives in `oed`; nothing imports a study. Run one with `python -m studies.NAME`.
"""

import sys

from oed.process_end import end_quietly_while_loading

# Python's own word for a module that it is about to run, whose imports are still to come.
if sys.argv[0] == "-m":
    end_quietly_while_loading(next(a for a in sys.orig_argv if a.startswith("studies.")))
