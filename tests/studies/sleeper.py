"""Cases that never end, for tests of what becomes of them: `python -m tests.studies.sleeper HOW DIR`."""

import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from oed.parallel_map import PROCESSES, parallel_map
from studies.case_runner import CaseRunner, Outcome, RowFile


@dataclass(frozen=True)
class Sleeper:
    folder: Path
    number: int

    @property
    def key(self) -> tuple[str, ...]:
        return (str(self.number),)


def sleep(case: Sleeper) -> Outcome:
    part = case.folder / f"{case.number}.part"
    part.write_text(str(os.getpid()))
    part.rename(part.with_suffix(".pid"))
    time.sleep(60)
    return {"status": "done"}


if __name__ == "__main__":
    folder = Path(sys.argv[2])
    sleepers = [Sleeper(folder, number) for number in range(2)]
    if sys.argv[1] == "pool":
        rows = RowFile(folder / "runs.csv", ("number",), ("status",))
        # Not `sleep` of this module, which other processes would not find under its name.
        from tests.studies import sleeper

        CaseRunner(sleeper.sleep, rows, "sleepers").run(
            [sleeper.Sleeper(folder, s.number) for s in sleepers], workers=2
        )
    else:
        os.environ[PROCESSES] = "2"
        parallel_map(sleep, sleepers)
