"""One recording: diagnosed, made feasible, simulated, and set beside what was published with it."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.commands.configurations import Diagnose, ModelName
from oed.commands.diagnose import Outcome, diagnose_into
from oed.commands.feasible import estimate
from oed.commands.from_data_set import prepare as prepare_estimate
from oed.commands.from_data_set import processing
from oed.commands.rollouts import held_out_tracks
from oed.diagnosis.inference.errors import Predictor
from oed.errors import OedError
from oed.estimation.feasible.calibration import FeasibleSettings
from oed.estimation.feasible.feasible_set import FeasibleSet
from oed.estimation.rollout import NotSimulated, roll_out
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.read_dataset import read_dataset
from oed.export.found_models import of_feasible
from oed.export.model_file import NAME as MODEL
from oed.parallel_map import cpu_seconds
from oed.report.joint_words import over_floor, place_words
from oed.report.provenance import Provenance
from studies.case_runner import FAILED
from studies.case_runner import Outcome as Line
from studies.public_arms.catalogue import ARMS
from studies.public_arms.sealed import SealedErrors, compare, of_predictor, of_torque
from studies.public_arms.visited import range_note

MODELS = ("base", "loop", "feasible", "peer")
BASE: ModelName = (
    "rotor"  # rigid body, rotor inertias, Coulomb and viscous friction: what `identify` takes
)
HORIZONS = (0.1, 0.4)  # [s]: sealed parts may be as short as 1.5 s
WINDOWS = 3  # of a recording
SMOKE_WEIGHT = (
    1e-3  # of the pull to bodies of the size of the links, in place of a cross-validation
)
KEY = ("arm", "content", "budget", "seed", "smoke")
VALUES = (
    "status",
    "joints",
    "fitted_seconds",
    "sealed_seconds",
    "cutoff",
    "floor",
    "torque",
    *(f"{x}_{m}" for x in ("rms", "floors", "relative", "interval") for m in MODELS),
    *(f"ratio_{m}" for m in MODELS if m != "loop"),
    *(f"flange_{m}" for m in MODELS if m != "peer"),
    "no_feasible",
    "no_peer",
    "verdict",
    "named",
    "unnamed",
    "contradicted",
    "range",
    "seconds",
)


@dataclass(frozen=True)
class Case:
    """One recording.

    Attributes:
        arm: Its name in the catalogue, or that of a data set's folder.
        content: Commit of the clone, or hash of the data set; empty where neither is there.
        budget: CPU time of the search [s].
        seed: Of everything random.
        smoke: Whether it only shows that it works.
        place: The clone, or the data set's folder.
        reports: Folder for whole diagnoses.
    """

    arm: str
    content: str
    budget: float
    seed: int
    smoke: bool
    place: Path
    reports: Path

    @property
    def kept(self) -> Path:
        """Where its data set and its diagnosis go."""
        return self.reports / self.arm.replace(" ", "_").replace("(", "").replace(")", "")

    @property
    def key(self) -> tuple[str, ...]:
        """As text, in the order of `KEY`."""
        smoke = "yes" if self.smoke else "no"
        return (self.arm, self.content, f"{self.budget:g}", str(self.seed), smoke)


def work(case: Case) -> Line:
    """A line of the table."""
    start = cpu_seconds()
    if not case.content:
        arm = ARMS[case.arm]
        return {"status": f"{FAILED}: no clone with {arm.marker}: {arm.fetch}, then --repo"}
    folder = _data(case)
    dataset = read_dataset(folder)
    outcome = diagnose_into(
        Diagnose(
            data=folder,
            out=case.kept / "diagnosis",
            model=BASE,
            smoke=case.smoke,
            seed=case.seed,
            budget=case.budget,
            quiet=True,
        )
    )
    return {
        "status": "done",
        **_numbers(case, dataset, outcome),
        "seconds": round(cpu_seconds() - start),
    }


def _data(case: Case) -> Path:
    """The data set's folder, imported anew where it is of a clone."""
    if case.arm not in ARMS:
        return case.place
    folder = case.kept / "import"
    shutil.rmtree(folder, ignore_errors=True)
    ARMS[case.arm].imported(case.place, folder)
    return folder / "data"


def _numbers(case: Case, dataset: DataSet, outcome: Outcome) -> dict[str, str | int | float]:
    found = outcome.found
    rows = prepare(dataset.recordings, processing(dataset))
    sealed = [p for p in rows if p.role == "test"]
    models: dict[str, Predictor] = {"base": found.before, "loop": found.after}
    told: dict[str, str | int | float] = {}
    try:
        models["feasible"] = feasible_beside(case, dataset)
    except OedError as error:
        told["no_feasible"] = str(error)[:200]
    errors = {name: [of_predictor(x, p) for p in sealed] for name, x in models.items()}
    try:
        errors |= _published(case, sealed)
    except OedError as error:
        told["no_peer"] = str(error)[:200]
    judged = compare(errors, sealed, np.random.default_rng(case.seed), ours="loop")
    return {
        "joints": dataset.robot.n,
        "fitted_seconds": _seconds(rows, "estimation"),
        "sealed_seconds": _seconds(rows, "test"),
        "cutoff": round(found.cutoff, 2),
        "floor": _listed(found.noise_floor),
        **_judged(judged, found.noise_floor),
        **_simulated(dataset, models),
        **told,
        "verdict": found.verdict,
        "named": "; ".join(f"{e.name} ({place_words(e.joint)})" for e in found.effects),
        "unnamed": "; ".join(f"{u.label} ({place_words(u.joint)})" for u in found.unexplained),
        "contradicted": "; ".join(found.contradicted),
        "range": range_note(rows),
    }


def feasible_beside(case: Case, dataset: DataSet) -> Predictor:
    """Bodies that can exist, beside what the loop found."""
    kept = tuple(r for r in dataset.recordings if r.role != "test")
    unsealed = replace(dataset, recordings=kept)
    prepared = prepare_estimate(unsealed, model=case.kept / "diagnosis" / MODEL)
    # Intervals of bodies are not shown here: the fewest resamples and poses.
    settings = FeasibleSettings(
        demands=FeasibleSet.of(prepared.model),
        weight=SMOKE_WEIGHT if case.smoke else None,
        resamples=2,
        poses=100,
        seed=case.seed,
    )
    result = estimate(prepared, settings)
    model = of_feasible(result, Provenance.collect(case, seed=case.seed), prepared.started)
    return Predictor(model.torque_model, model.parameters)


def _published(
    case: Case, sealed: Sequence[Prepared]
) -> dict[str, list[Float[ndarray, "_ joints"]]]:
    """Errors of the peer's own model on the sealed rows; none where nothing of it runs."""
    peer = ARMS[case.arm].peer if case.arm in ARMS else None
    if peer is None or peer.torque is None:
        return {}
    torque = peer.torque(case.place, case.kept / "published")
    return {"peer": [of_torque(torque, p) for p in sealed]}


def _judged(judged: SealedErrors, floor: Float[ndarray, " joints"]) -> dict[str, str | float]:
    told: dict[str, str | float] = {"torque": _listed(judged.torque)}
    for name, rms in judged.rms.items():
        told |= {
            f"rms_{name}": _listed(rms),
            f"floors_{name}": float(f"{over_floor(rms, floor):.3g}"),
            f"relative_{name}": round(judged.relative[name], 4),
            f"interval_{name}": _listed(judged.interval[name]),
        }
    return told | {f"ratio_{name}": _listed(ends) for name, ends in judged.ratio.items()}


def _simulated(dataset: DataSet, models: Mapping[str, Predictor]) -> dict[str, str | float]:
    """Flange error after the horizons in millimetres.

    Left out where nothing is long enough, or a model has no simulation.
    """
    tracks = held_out_tracks(dataset, longest=HORIZONS[-1], roles=("test",))
    told: dict[str, str | float] = {}
    for name, x in models.items():
        with contextlib.suppress(ValueError, NotSimulated):
            rolled = roll_out(x.model, x.parameters, tracks, horizons=HORIZONS, windows=WINDOWS)
            told[f"flange_{name}"] = _listed(1000 * rolled.flange)
    return told


def _seconds(rows: Sequence[Prepared], role: str) -> float:
    return round(sum(len(p.motion) / p.band.rate for p in rows if p.role == role), 1)


def _listed(values: Sequence[float] | Float[ndarray, " k"]) -> str:
    return " ".join(f"{float(x):.3g}" for x in values)
