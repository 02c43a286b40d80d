"""`oed diagnose`: what the torque model lacks, what it is, and what adding it gains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oed.commands.configurations import Diagnose, ModelName
from oed.commands.diagnosed_torques import diagnosed_torques
from oed.commands.from_data_set import prepare
from oed.commands.from_log import imported, on_data_set
from oed.commands.telling import say, speak
from oed.diagnosis.diagnose import Diagnosis, diagnose
from oed.diagnosis.discrimination.next_motion import NextExperiment, design_next
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.settings import ProcessingSettings
from oed.experiment.read_dataset import read_dataset
from oed.export.found_models import of_diagnosis
from oed.export.model import Model
from oed.export.model_file import NAME as MODEL
from oed.export.model_file import write_model
from oed.one_thread import on_one_thread
from oed.report.diagnosis_report import write_diagnosis
from oed.report.doubts import far_off, names_of
from oed.report.joint_words import over_floor
from oed.report.next_steps import Run, next_steps
from oed.report.provenance import Provenance
from oed.report.study_files import CLOSE_LOOP
from oed.report.term_words import in_words, words_of_terms
from oed.report.unnamed_terms import unnamed_terms

MOTIONS = 48  # random motions of which the most discriminating is proposed
FEW_TERMS, FEW_MOTIONS = 1, 6  # of a diagnosis that is made smaller


@dataclass(frozen=True)
class Outcome:
    """A diagnosis and what to do next.

    Attributes:
        dataset: What was diagnosed.
        notes: What is doubtful about its numbers, and where its logs paused.
        found: The diagnosis.
        following: The motion that tells apart what is open; None where no name is.
        settings: How the recordings were processed.
        started: The model that it started from; None where it is a named one.
    """

    dataset: DataSet
    notes: tuple[str, ...]
    found: Diagnosis
    following: NextExperiment | None
    settings: ProcessingSettings
    started: Model | None = None


@on_one_thread
def diagnose_data(
    data: DataSet | str | Path,
    *,
    model: ModelName | Path | None = None,
    max_effects: int | None = None,
    candidates: Sequence[str] = (),
    budget: float | None = None,
    seed: int = 0,
) -> Outcome:
    """Find out what the torque model of an arm lacks, and what adding it gains.

    Args:
        data: A data set, or its folder.
        model: Base model, as of `identify`; or a model.json, to look for what that still lacks.
        max_effects: Most effects to add; three a joint if None, at least six; 0 only tests the model.
        candidates: Effects that may be named; the whole catalogue if empty.
        budget: CPU time after which nothing more is looked for [s].
        seed: Seed of everything random.

    Returns:
        The diagnosis in `found` (verdict, effects, errors before and after [N m]), and in `following`
        the motion that tells apart what is open, if anything is.

    Raises:
        DataSetError: If the folder holds no data set that can be used.
        OedError: If a joint stands still, or the data determine nothing.
    """
    dataset = data if isinstance(data, DataSet) else read_dataset(data)
    config = Diagnose(
        data=Path(dataset.name),
        out=Path(),
        model=model,
        max_effects=max_effects,
        candidates=tuple(candidates),
        budget=budget,
        seed=seed,
    )
    return find(config, dataset)


def find(config: Diagnose, dataset: DataSet) -> Outcome:
    """Diagnose a data set as the command was told to."""
    ready = prepare(dataset, model=config.model)
    started, most = ready.started, config.max_effects
    found = diagnose(
        dataset,
        ready.model,
        settings=ready.settings,
        parameters=None if started is None else started.parameters_of(ready.model),
        known=ready.known,
        noise_of=ready.noise_of,
        names=config.candidates or tuple(CATALOGUE),
        most=FEW_TERMS if most is None and config.smoke else most,
        seed=config.seed,
        budget=config.budget,
        say=say,
    )
    rng = np.random.default_rng(config.seed)
    motions = FEW_MOTIONS if config.smoke else MOTIONS
    following = design_next(found, rng, candidates=motions)
    notes = (*ready.notes, *found.notes)
    return Outcome(dataset, notes, found, following, ready.settings, started)


def diagnose_into(config: Diagnose) -> Outcome:
    """Diagnose into a folder, which is refused before the work if results cannot go there."""
    with CLOSE_LOOP.in_folder(config.out, config.inputs) as results:
        config = imported(config, config.out)
        outcome = find(config, read_dataset(config.data))
        provenance = Provenance.collect(config, seed=config.seed)
        with results.replaced() as new:
            model = of_diagnosis(outcome.found, outcome.dataset.name, provenance, outcome.started)
            write_model(model, new / MODEL, home=results.folder)
            write_diagnosis(
                outcome.found,
                outcome.following,
                torques=diagnosed_torques(outcome.found, outcome.dataset, outcome.settings),
                data=outcome.dataset.name,
                joints=outcome.dataset.robot.joint_names,
                notes=outcome.notes,
                run=_where(config),
                provenance=provenance,
                out=new,
            )
    return outcome


def run(config: Diagnose) -> int:
    """Diagnose, and leave diagnosis.json, report.html, model.json and figures."""
    speak(quiet=config.quiet)
    _summarise(diagnose_into(config), on_data_set(config, config.out))
    return 0


def _where(config: Diagnose) -> Run:
    return Run(config.data, config.out, config.budget)


def _summarise(outcome: Outcome, config: Diagnose) -> None:
    found, words = outcome.found, words_of_terms(outcome.found)
    print(f"verdict: {found.verdict}")
    for effect in found.effects:
        values = ", ".join(
            f"{p.name} = {p.value:.4g} "
            + (f"(standard deviation {p.std:.2g})" if p.std is not None else f"({p.note})")
            for p in effect.parameters
        )
        print(f"  {names_of(effect)}, probability {effect.probability:.3f}: {values}")
    for item in unnamed_terms(found):
        carries = "" if item.carried is None else f"carries {item.carried:.3g} noise floors; "
        print(
            f"  without a name (joint {item.joint + 1}): {item.what}; in the model: {item.model_has}; {carries}"
            f"{found.budget.role} error there {item.before:.3g} -> {item.after:.3g} noise floors"
        )
    for text in found.contradicted:
        print(f"  {in_words(text, words)}")
    for errors in found.errors:
        old, new = (over_floor(x, found.noise_floor) for x in (errors.before, errors.after))
        print(
            f"  {errors.role} error: {old:.3g} -> {new:.3g} times the noise floor"
            f"{far_off(errors.after, found.noise_floor)}"
        )
    for step in next_steps(found, outcome.following, _where(config)):
        print(f"next: {step.text}")
        for line in step.commands:
            print(f"    {line}")
    print(f"open {config.out / 'report.html'}")
