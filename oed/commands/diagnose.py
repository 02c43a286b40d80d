"""`oed diagnose`: what the torque model lacks, what it is, and what adding it gains."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oed.commands.by_evidence import diagnose_by_evidence
from oed.commands.configurations import Diagnose
from oed.commands.telling import say, speak
from oed.diagnosis.diagnosis import Diagnosis, diagnose
from oed.diagnosis.evidence.unlocated import CLEAR_UNSEEN
from oed.diagnosis.rivals.discrimination import NextExperiment, design_discriminating
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.models import build_model
from oed.experiment.dataset import DataSet
from oed.experiment.read_dataset import read_dataset
from oed.experiment.stretches import gap_notes, gap_record
from oed.report.diagnosis_report import write_diagnosis
from oed.report.effect_section import p_value_text
from oed.report.effect_words import known_parameters
from oed.report.joint_words import over_floor, place_words
from oed.report.provenance import Provenance
from oed.report.study_files import CLOSE_LOOP

SMOKE_MOTIONS = 6
MOTIONS = 48  # random motions of which the most discriminating is proposed


@dataclass(frozen=True)
class Outcome:
    """A diagnosis and what to do next.

    Attributes:
        dataset: What was diagnosed.
        notes: What is doubtful about its numbers, and where its logs paused.
        found: The diagnosis.
        following: The motion that tells rivals apart; None without rivals.
    """

    dataset: DataSet
    notes: tuple[str, ...]
    found: Diagnosis
    following: NextExperiment | None


def diagnose_data(data: DataSet | str | Path, *, seed: int = 0) -> Outcome:
    """Find out what the torque model of an arm lacks, and what adding it gains.

    Args:
        data: A data set, or its folder.
        seed: Of everything random.

    Returns:
        The diagnosis, and the motion that tells its rivals apart where there are any.

    Raises:
        DataSetError: If the folder holds no data set that can be used.
    """
    dataset = data if isinstance(data, DataSet) else read_dataset(data)
    return find(Diagnose(data=Path(dataset.name), out=Path(), seed=seed), dataset)


def find(config: Diagnose, dataset: DataSet) -> Outcome:
    """Diagnose, and design the next experiment where rivals remain."""
    settings = settings_of(config)
    for file, column in dataset.unused:
        say(f"note: {file}: column {column!r} is not used")
    notes = (*dataset.notes, *gap_notes(gap_record(dataset), shortest=0.0))
    for note in notes:
        say(f"note: {note}")
    name = str(config.model or base_model(dataset))
    say(f"base model {name!r}")
    model = build_model(name, dataset.robot)
    found = diagnose(dataset, model, settings, say)
    pairs = found.rival_pairs()
    following = None
    if found.verdict == "ambiguous" and pairs:
        say(f"designing a motion that tells {len(pairs)} pair(s) of rivals apart")
        following = design_discriminating(
            found.shop,
            pairs,
            np.random.default_rng(config.seed),
            candidates=SMOKE_MOTIONS if config.smoke else MOTIONS,
        )
    return Outcome(dataset, (*notes, *found.notes), found, following)


def base_model(dataset: DataSet) -> str:
    """What is declared is nothing that the model lacks."""
    return "standard" if dataset.drive.rotor_inertia is None else "rotor"


def write(outcome: Outcome, config: Diagnose, out: Path) -> None:
    """Leave the results in a folder."""
    write_diagnosis(
        outcome.found,
        outcome.following,
        data=outcome.dataset.name,
        joints=outcome.dataset.robot.joint_names,
        notes=outcome.notes,
        settings=settings_of(config),
        provenance=Provenance.collect(config, seed=config.seed),
        out=out,
    )


def diagnose_into(config: Diagnose) -> Outcome:
    """Both, in a folder that is refused before the work if results cannot go there."""
    with CLOSE_LOOP.in_folder(config.out, [config.data]) as results:
        outcome = find(config, read_dataset(config.data))
        with results.replaced() as new:
            write(outcome, config, new)
    return outcome


def run(config: Diagnose) -> int:
    """Diagnose, and leave diagnosis.json, report.html and figures."""
    speak(quiet=config.quiet)
    if config.method == "evidence":
        diagnose_by_evidence(config)
        return 0
    _summarise(diagnose_into(config), config)
    return 0


def settings_of(config: Diagnose) -> DiagnosisSettings:
    """The diagnosis's settings."""
    settings = DiagnosisSettings(
        max_effects=config.max_effects,
        seed=config.seed,
        candidates=config.candidates or tuple(CATALOGUE),
    )
    return settings.made_smaller() if config.smoke else settings


def _summarise(outcome: Outcome, config: Diagnose) -> None:
    found = outcome.found
    print(f"verdict: {found.verdict}")
    for effect in found.effects:
        known = known_parameters(effect, found.shop.context, outcome.dataset.robot.joints)
        values = ", ".join(
            f"{p.label} = {p.value:.4g} " + (f"± {p.std:.2g}" if p.note is None else f"({p.note})")
            for p in known
        )
        print(
            f"  {effect.name} ({place_words(effect.joint)}): {values}; by accident: {p_value_text(effect.p_value)}"
        )
    for item in found.unexplained:
        print(f"  unexplained on joint {item.joint + 1}: {item.label}")
    if np.any(found.expected > CLEAR_UNSEEN):
        worst = int(np.argmax(found.expected))
        print(
            "  the estimation recordings leave parameters so uncertain that a validation error of "
            f"{found.expected[worst]:.3g} noise floors is to be expected at joint {worst + 1}"
        )
    for proof in found.proof:
        old, new = (over_floor(x, found.noise_floor) for x in (proof.before, proof.after))
        print(f"  {proof.role} error: {old:.3g} -> {new:.3g} times the noise floor")
    print(f"open {config.out / 'report.html'}")
