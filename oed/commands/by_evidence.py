"""`oed diagnose --method evidence`: the same question, by one criterion with a sealed test."""

from __future__ import annotations

from pathlib import Path

from oed.commands.configurations import Diagnose
from oed.commands.from_data_set import model_for
from oed.commands.telling import say
from oed.diagnosis_new.diagnose import Diagnosis, diagnose
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.models import build_model
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.dataset import DataSet
from oed.experiment.read_dataset import read_dataset
from oed.experiment.stretches import gap_notes, gap_record
from oed.export.found_models import of_diagnosis
from oed.export.model_file import NAME as MODEL
from oed.export.model_file import write_model
from oed.report.evidence_report import write_evidence
from oed.report.joint_words import over_floor, place_words
from oed.report.provenance import Provenance
from oed.report.study_files import CLOSE_LOOP

SMOKE_EFFECTS = 1


def diagnose_by_evidence(config: Diagnose) -> Diagnosis:
    """Diagnose into a folder, and say in a few lines what was found."""
    with CLOSE_LOOP.in_folder(config.out, [config.data]) as results:
        dataset = read_dataset(config.data)
        notes = (*dataset.notes, *gap_notes(gap_record(dataset), shortest=0.0))
        for note in notes:
            say(f"note: {note}")
        found = diagnose(
            dataset,
            _base_model(config, dataset),
            names=config.candidates or tuple(CATALOGUE),
            most=SMOKE_EFFECTS if config.smoke else config.max_effects,
            seed=config.seed,
            budget=config.budget,
            say=say,
        )
        provenance = Provenance.collect(config, seed=config.seed)
        with results.replaced() as new:
            model = of_diagnosis(found, dataset.name, provenance)
            write_model(model, new / MODEL, home=results.folder)
            write_evidence(
                found,
                data=dataset.name,
                joints=dataset.robot.joint_names,
                notes=(*notes, *found.notes),
                provenance=provenance,
                out=new,
            )
    _summarise(found, config)
    return found


def _base_model(config: Diagnose, dataset: DataSet) -> TorqueModel:
    """As it is named or found before; what is declared is nothing that the model lacks."""
    if isinstance(config.model, Path):
        return model_for(dataset, config.model).torque_model
    declared = "standard" if dataset.drive.rotor_inertia is None else "rotor"
    return build_model(config.model or declared, dataset.robot)


def _summarise(found: Diagnosis, config: Diagnose) -> None:
    print(f"verdict: {found.verdict}")
    for effect in found.effects:
        where = place_words(effect.joint)
        print(f"  {effect.name} ({where}): probability {effect.probability:.3f}")
    for item in found.unexplained:
        print(f"  unexplained on joint {item.joint + 1}: {item.label}")
    for words in found.contradicted:
        print(f"  {words}")
    for errors in found.errors:
        old, new = (over_floor(x, found.noise_floor) for x in (errors.before, errors.after))
        print(f"  {errors.role} error: {old:.3g} -> {new:.3g} times the noise floor")
    print(f"open {config.out / 'report.html'}")
