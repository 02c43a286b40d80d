"""`oed demo`: the whole way on a simulated arm, with no input."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from oed.commands import check, design, diagnose, export, feasible, identify
from oed.commands.configurations import Check, Demo, Design, Diagnose, Export, Feasible, Identify
from oed.commands.telling import say, speak
from oed.dynamics.motion import Motion
from oed.experiment.dataset import DataSet
from oed.experiment.imi_recordings import control_period, record_imi
from oed.experiment.recording import Role
from oed.experiment.write_dataset import write_dataset
from oed.export.model_file import NAME
from oed.report.page import Links, Page, Section, Verdict, write_page
from oed.report.provenance import Provenance
from oed.report.study_files import DEMO, RECORDINGS

ARM = "builtin:imi_scara"
MODEL = "standard"  # direct drives: the arm has no rotors behind gears
REPETITIONS, FEW = 6, 2
EVALUATIONS, FEW_EVALUATIONS = 300, 60  # enough for two joints: half a minute of four in all
FORMS = ("c", "mujoco")  # to which the demo exports its model
ROLES: tuple[Role, ...] = ("estimation", "validation", "test")
PAGES = (
    ("The motion", "design/report.html", "designed for this arm; proven to keep its limits"),
    ("The recordings", "check/report.html", "looked over before any fit"),
    ("The parameters", "identify/report.html", "with 95 % intervals, and their errors held out"),
    ("What the model lacks", "diagnosis/report.html", "the effect found, and what it gains"),
    (
        "A model for a simulator",
        "feasible/report.html",
        "bodies that exist, beside the effect found; URDF, SDF, MJCF",
    ),
    (
        "The model as code",
        "export/oed_model.h",
        "C for a controller, with the effect found; beside it a MuJoCo simulation",
    ),
)


def run(config: Demo) -> int:
    """Go the whole way, and leave a page that links all others."""
    start = time.perf_counter()
    out = config.out
    with DEMO.in_folder(out) as results:
        for number, (title, step) in enumerate(_steps(config), 1):
            speak(quiet=config.quiet)
            say(f"\n[{number}] {title}")
            if status := step():
                return status
        seconds = time.perf_counter() - start
        with results.replaced() as new:
            write_page(new / "index.html", _page(config, seconds))
            Provenance.collect(config, seed=config.seed).write(new / "provenance.json")
    print(f"\nopen {out / 'index.html'} ({seconds:.0f} s)")
    return 0


def _steps(config: Demo) -> tuple[tuple[str, Callable[[], int]], ...]:
    """Title and work of each step, in order; each works on what the ones before it left."""
    out, quiet, seed = config.out, config.quiet, config.seed
    size = {"smoke": config.smoke, "seed": seed}
    data = out / "recordings"
    given = {"quiet": quiet, "data": data}
    return (
        ("designing a motion", lambda: design.run(_design(config, out / "design", seed))),
        ("recording it, with another for validation and one for the test", lambda: _record(config)),
        (
            "checking the recordings",
            lambda: check.run(Check(**given, out=out / "check", model=MODEL)),
        ),
        (
            "estimating parameters",
            lambda: identify.run(Identify(**given, out=out / "identify", model=MODEL)),
        ),
        (
            "looking for what the model lacks",
            lambda: diagnose.run(Diagnose(**given, **size, out=out / "diagnosis")),
        ),
        (
            "estimating bodies beside what was found",
            lambda: feasible.run(
                Feasible(**given, **size, out=out / "feasible", model=out / "diagnosis" / NAME)
            ),
        ),
        (
            "writing it as code and as a simulation",
            lambda: export.run(
                Export(model=out / "feasible", to=FORMS, out=out / "export", quiet=quiet)
            ),
        ),
    )


def _design(config: Demo, out: Path, seed: int) -> Design:
    evaluations = FEW_EVALUATIONS if config.smoke else EVALUATIONS
    return Design(
        robot=ARM, out=out, evaluations=evaluations, smoke=config.smoke, seed=seed,
        quiet=config.quiet,
    )  # fmt: skip


def _record(config: Demo) -> int:
    """Record one designed motion for each role; those of the other roles have other seeds."""
    motions: list[tuple[str, Role, Motion]] = [
        (role, role, _motion(_design(config, config.out, config.seed + k)))
        for k, role in enumerate(ROLES)
    ]
    dataset: DataSet = record_imi(
        motions,
        np.random.default_rng(config.seed),
        hidden=config.hidden,
        repetitions=FEW if config.smoke else REPETITIONS,
        source="simulated by oed demo",
    )
    data = config.out / "recordings"
    with RECORDINGS.in_folder(data) as results, results.replaced() as new:
        write_dataset(dataset, new)
    say(f"  {len(motions)} recordings in {data}, with {config.hidden!r} undeclared")
    return 0


def _motion(config: Design) -> Motion:
    """One period of a design, at the controller's samples."""
    # The page of the first has the bound; nothing shows those of the others.
    found = design.find(config, design.robot_of(config), bounded=False).design
    step = control_period()
    return found.motion(np.arange(round(found.horizon / step)) * step)


def _page(config: Demo, seconds: float) -> Page:
    verdict = Verdict(
        "good",
        "From nothing to a model, on a simulated arm.",
        f"Undeclared: {config.hidden}. {seconds:.0f} s in all; seed {config.seed}.",
    )
    return Page("oed demo", verdict, (Section("Pages", (Links(PAGES),)),))
