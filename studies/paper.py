"""The main job, `make paper`: the paper's experiment, its figures, your data, and the loop closed.

    python -m studies.paper [--data DIR] [--out DIR] [--smoke]

1. The paper's experiment in simulation: results/paper, then paper_figures/figure_02 … 11.
2. Every data set at hand identified: --data, else those in ../shared/data, if any.
3. The paper's arm recorded with an effect that its model does not declare: identified, diagnosed,
   the effect added, the error before and after: results/loop_scara.

What is finished and unchanged is kept from an earlier run.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.commands.options import Folder, OutFolder, parse
from oed.parallel_map import processes
from oed.process_end import leave
from paper_figures.writing import HERE, RESULTS, write_all
from studies import close_loop, identify, scara_recordings
from studies.data_folders import REPOSITORY, data_sets
from studies.paper_experiment import experiment


@dataclass(frozen=True)
class Step:
    """One part of the job.

    Attributes:
        title: What it does.
        run: Does it; 0 if all went well.
    """

    title: str
    run: Callable[[], int]


@dataclass(frozen=True)
class Options:
    """The paper's experiment, its figures, your data, and the loop closed.

    Attributes:
        data: A data set, or a folder of data sets; those in ../shared/data if not given.
        out: Folder for reports.
        results: Folder for results.
        smoke: Every step, as small as can be.
    """

    data: Folder | None = None
    out: OutFolder = REPOSITORY / "out"
    results: OutFolder = REPOSITORY / "results"
    smoke: bool = False


def main(arguments: Sequence[str] | None = None) -> int:
    """Run all steps; the first failure ends the job with its code."""
    given = parse(Options, prog="python -m studies.paper", arguments=arguments)
    start = time.perf_counter()
    for number, step in enumerate(_steps(given.data, given.out, given.results, given.smoke), 1):
        _say(f"[{number}] {step.title}")
        begun = time.perf_counter()
        code = step.run()
        if code:
            return code
        _say(f"[{number}] done in {time.perf_counter() - begun:.0f} s")
    _say(f"all done in {time.perf_counter() - start:.0f} s; reports in {given.out}")
    return 0


def _steps(data: Path | None, out: Path, results: Path, smoke: bool) -> list[Step]:
    small, wide = ["--smoke"] if smoke else [], ["--workers", str(processes())]
    recordings = out / "scara_recordings"
    loop = results / "loop_scara"
    steps = [
        Step(
            "the paper's experiment, rebuilt",
            lambda: experiment.main(["--out", str(results / "paper"), *(small or wide)]),
        ),
        Step(
            "the paper's figures",
            # A small experiment need not show what the captions claim: then of what is kept.
            lambda: _draw(*((RESULTS, out / "figures") if smoke else (results / "paper", HERE))),
        ),
    ]
    steps += [
        Step(
            f"identifying {folder.name}",
            lambda folder=folder: identify.main(
                ["--data", str(folder), "--out", str(out / "identify" / folder.name)]
            ),
        )
        for folder in data_sets(data)
    ]
    steps.append(
        Step(
            "recording the paper's arm with an undeclared effect",
            lambda: scara_recordings.main(["--out", str(recordings), *small]),
        )
    )
    steps.append(
        Step(
            "closing the loop: what does the model lack?",
            lambda: close_loop.main(["--data", str(recordings), "--out", str(loop), *small]),
        )
    )
    return steps


def _draw(results: Path, out: Path) -> int:
    for file in write_all(results, out):
        _say(f"  {file}")
    return 0


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    leave(main, "studies.paper", "what its steps have left so far is there")
