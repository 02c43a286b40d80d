"""`oed calibrate`: from recordings to a model that runs, in one command."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from oed.commands import diagnose, export, feasible, identify
from oed.commands.configurations import Calibrate, Diagnose, Export, Feasible, Identify
from oed.commands.from_log import imported
from oed.commands.refine import refine
from oed.commands.rollouts import BASE_OF_BODIES, base_of_bodies, models_in, rollouts
from oed.commands.telling import say, speak
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.estimation.rollout import WINDOWS
from oed.experiment.read_dataset import read_dataset
from oed.export.model_file import NAME, load_model, write_model
from oed.export.registry import find_exporter
from oed.report.calibrate_page import calibrate_page
from oed.report.json_file import read_json, write_json
from oed.report.page import write_page
from oed.report.provenance import Provenance
from oed.report.study_files import CALIBRATE

REFINED, REFINEMENT = "refined", "refinement.json"
FEW_WINDOWS = 1  # of a recording, to see that it works


def run(config: Calibrate) -> int:
    """Go all steps, and leave a page that links theirs and says what came out."""
    start = time.perf_counter()
    for form in config.to:
        find_exporter(form)  # refused before the work
    for name in config.candidates:
        if name not in CATALOGUE:
            raise ValueError(f"--candidates: no effect {name!r}; there are {', '.join(CATALOGUE)}")
    with CALIBRATE.in_folder(config.out, config.inputs) as results:
        speak(quiet=config.quiet)
        config = imported(config, config.out)
        read_dataset(config.data).robot.require_newton_metres(str(config.data))
        steps = _steps(config)
        for number, (title, step) in enumerate(steps, 1):
            speak(quiet=config.quiet)
            say(f"\n[{number}] {title}")
            if status := step():
                return status
        record = _record(config)
        dataset = read_dataset(config.data)
        say(f"\n[{len(steps) + 1}] simulating what was not fitted")
        windows = FEW_WINDOWS if config.smoke else WINDOWS
        models = dict(models_in(config.out, dataset))
        models[BASE_OF_BODIES] = base_of_bodies(
            dataset, config.model, config.prior, smoke=config.smoke, seed=config.seed
        )
        if _last(config).name == REFINED:
            found = load_model(_last(config) / NAME)
            models[REFINED] = (found.torque_model, found.parameters)
        rolled = rollouts(dataset, models, windows=windows)
        record |= {"joints": list(dataset.robot.joint_names), "rollout": rolled}
        with results.replaced() as new:
            provenance = Provenance.collect(config, seed=config.seed)
            write_json(new / "calibration.json", record)
            write_page(
                new / "index.html", calibrate_page(read_json(new / "calibration.json"), provenance)
            )
    print(f"\nopen {config.out / 'index.html'} ({time.perf_counter() - start:.0f} s)")
    return 0


def _steps(config: Calibrate) -> tuple[tuple[str, Callable[[], int]], ...]:
    """Title and work of each step; each works on what the ones before it left."""
    out = config.out
    given = {"data": config.data, "quiet": config.quiet}
    whole = out / "diagnosis" / NAME
    return (
        (
            "estimating base parameters",
            lambda: identify.run(Identify(**given, out=out / "identify", model=config.model)),
        ),
        (
            "looking for what the model lacks",
            lambda: diagnose.run(
                Diagnose(
                    **given,
                    out=out / "diagnosis",
                    smoke=config.smoke,
                    model=config.model,
                    max_effects=config.max_effects,
                    candidates=config.candidates,
                    budget=config.budget,
                    seed=config.seed,
                )
            ),
        ),
        (
            "estimating bodies beside what was found",
            lambda: feasible.run(
                Feasible(
                    **given,
                    out=out / "feasible",
                    smoke=config.smoke,
                    model=whole,
                    prior=config.prior,
                    seed=config.seed,
                )
            ),
        ),
        *([("refining by rollout", lambda: _refine(config))] if config.refine else []),
        (
            f"exporting the model to {', '.join(config.to)}",
            lambda: export.run(
                Export(
                    model=_last(config),
                    to=config.to,
                    out=out / "export",
                    rate=config.rate,
                    quiet=config.quiet,
                )
            ),
        ),
    )


def _refine(config: Calibrate) -> int:
    """Leave refinement.json, and model.json where it is accepted."""
    folder = config.out / REFINED
    folder.mkdir(exist_ok=True)
    (folder / NAME).unlink(missing_ok=True)
    windows = FEW_WINDOWS if config.smoke else WINDOWS
    model = load_model(config.out / "feasible" / NAME)
    found, record = refine(read_dataset(config.data), model, windows=windows)
    write_json(folder / REFINEMENT, record)
    if found is not None:
        write_model(found, folder / NAME)
    say("accepted" if found is not None else f"not accepted: {record['reason']}")
    return 0


def _last(config: Calibrate) -> Path:
    """Folder of the model that leaves: the refined one where there is one."""
    refined = config.out / REFINED
    is_there = config.refine is not None and (refined / NAME).is_file()
    return refined if is_there else config.out / "feasible"


def _record(config: Calibrate) -> dict:
    """What the page says, from the records of the steps."""
    out = config.out
    diagnosis = read_json(out / "diagnosis" / "diagnosis.json")
    bodies = read_json(out / "feasible" / "estimate.json")
    exported = read_json(out / "export" / "export.json")
    return {
        "format": 1,
        "data": bodies["data"],
        "verdict": diagnosis["verdict"],
        "effects": [{k: e[k] for k in ("name", "joint")} for e in diagnosis["effects"]],
        "unexplained": len(diagnosis["unexplained"]),
        "without_name": [u["words"] for u in diagnosis["unexplained"]],
        "rms": diagnosis["rms"],
        "links": bodies["links"],
        "changes_from_file": bodies["changes_from_file"],
        "warnings": bodies["warnings"],
        "exports": {name: told["files"] for name, told in exported["exports"].items()},
        "refinement": read_json(out / REFINED / REFINEMENT) if config.refine else None,
    }
