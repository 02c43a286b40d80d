"""What does the torque model lack, what is it, and what does adding it gain?

    python -m studies.close_loop --data DIR --out DIR [--model NAME] [--max-effects K]
                                 [--candidates NAME …] [--smoke] [--seed N]

Reads a data set and a base model, traces the residual to missing effects or says honestly that
it cannot, and leaves diagnosis.json, report.html, figures and, if rivals remain, next_experiment/.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oed.diagnosis.diagnosis import Diagnosis, diagnose
from oed.diagnosis.evidence.unlocated import CLEAR_UNSEEN
from oed.diagnosis.rivals.discrimination import NextExperiment, design_discriminating
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.models import MODELS, build_model
from oed.errors import OedError
from oed.experiment.dataset import DataSet
from oed.experiment.read_dataset import read_dataset
from oed.experiment.stretches import gap_notes, gap_record
from oed.report.diagnosis_report import write_diagnosis
from oed.report.effect_section import p_value_text
from oed.report.effect_words import known_parameters
from oed.report.joint_words import over_floor, place_words
from oed.report.output_folder import named_folder
from oed.report.provenance import Provenance
from oed.report.study_files import CLOSE_LOOP
from studies.interrupt import leave

SMOKE_MOTIONS = 6
MOTIONS = 48  # random motions of which the most discriminating is proposed


@dataclass(frozen=True)
class Config:
    """What to diagnose, and how.

    Attributes:
        data: Folder of the data set.
        out: Folder to leave results in.
        model: Name of the base model; None for the standard one, with rotor inertias if the data
            set declares them.
        max_effects: Most effects that may be added; None for two a joint, at least four.
        candidates: Names of the catalogue that may be given.
        smoke: Whether to use few surrogates and motions.
        seed: Of surrogates, bootstrap and motions.
    """

    data: Path
    out: Path
    model: str | None = None
    max_effects: int | None = None
    candidates: tuple[str, ...] = tuple(CATALOGUE)
    smoke: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        if self.max_effects is not None and self.max_effects < 0:
            raise ValueError(
                f"--max-effects {self.max_effects} must not be negative; 0 only tests the model"
            )
        if self.seed < 0:
            raise ValueError(f"--seed {self.seed} must not be negative")

    @property
    def settings(self) -> DiagnosisSettings:
        """The diagnosis's settings."""
        settings = DiagnosisSettings(
            max_effects=self.max_effects, seed=self.seed, candidates=self.candidates
        )
        return settings.made_smaller() if self.smoke else settings


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


def run(config: Config) -> Outcome:
    """Read, diagnose, and design the next experiment where rivals remain."""
    settings = config.settings
    dataset = read_dataset(config.data)
    for file, column in dataset.unused:
        _say(f"note: {file}: column {column!r} is not used")
    notes = (*dataset.notes, *gap_notes(gap_record(dataset), shortest=0.0))
    for note in notes:
        _say(f"note: {note}")
    name = config.model or base_model(dataset)
    _say(f"base model {name!r}")
    model = build_model(name, dataset.robot)
    found = diagnose(dataset, model, settings, _say)
    pairs = found.rival_pairs()
    following = None
    if found.verdict == "ambiguous" and pairs:
        _say(f"designing a motion that tells {len(pairs)} pair(s) of rivals apart")
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


def write(outcome: Outcome, config: Config, out: Path) -> None:
    """Leave the results in a folder."""
    write_diagnosis(
        outcome.found,
        outcome.following,
        data=outcome.dataset.name,
        joints=outcome.dataset.robot.joint_names,
        notes=outcome.notes,
        settings=config.settings,
        provenance=Provenance.collect(config, seed=config.seed),
        out=out,
    )


def run_and_write(config: Config) -> Outcome:
    """Both, in a folder that is refused before the work if results cannot go there."""
    with CLOSE_LOOP.in_folder(config.out, [config.data]) as results:
        outcome = run(config)
        with results.replaced() as new:
            write(outcome, config, new)
    return outcome


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; 0 if all went well, 2 if the input cannot be used."""
    try:
        config = _parse(arguments)
        outcome = run_and_write(config)
    except (OedError, ValueError, OSError) as error:
        sys.stderr.write(f"studies.close_loop: {error}\n")
        return 2
    _summarise(outcome, config)
    return 0


def _summarise(outcome: Outcome, config: Config) -> None:
    found = outcome.found
    _say(f"verdict: {found.verdict}")
    for effect in found.effects:
        known = known_parameters(effect, found.shop.context, outcome.dataset.robot.joints)
        values = ", ".join(
            f"{p.label} = {p.value:.4g} " + (f"± {p.std:.2g}" if p.note is None else f"({p.note})")
            for p in known
        )
        _say(
            f"  {effect.name} ({place_words(effect.joint)}): {values}; by accident: {p_value_text(effect.p_value)}"
        )
    for item in found.unexplained:
        _say(f"  unexplained on joint {item.joint + 1}: {item.label}")
    if np.any(found.expected > CLEAR_UNSEEN):
        worst = int(np.argmax(found.expected))
        _say(
            "  the estimation recordings leave parameters so uncertain that a validation error of "
            f"{found.expected[worst]:.3g} noise floors is to be expected at joint {worst + 1}"
        )
    for proof in found.proof:
        old, new = (over_floor(x, found.noise_floor) for x in (proof.before, proof.after))
        _say(f"  {proof.role} error: {old:.3g} -> {new:.3g} times the noise floor")
    _say(f"written to {config.out}")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _parse(arguments: Sequence[str] | None) -> Config:
    parser = argparse.ArgumentParser(
        prog="studies.close_loop", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("--data", type=Path, required=True, help="folder of the data set")
    parser.add_argument("--out", type=named_folder, required=True, help="folder for the results")
    parser.add_argument(
        "--model",
        choices=sorted(MODELS),
        help="base model: standard unless given, rotor if the data set declares rotor inertias",
    )
    parser.add_argument(
        "--max-effects",
        type=int,
        help="most effects to add: two a joint unless given, at least four",
    )
    parser.add_argument(
        "--candidates",
        nargs="+",
        metavar="NAME",
        default=list(CATALOGUE),
        help="effects that may be named, all of the catalogue by default",
    )
    parser.add_argument("--smoke", action="store_true", help="few surrogates and motions")
    parser.add_argument("--seed", type=int, default=0, help="of surrogates and bootstrap")
    given = parser.parse_args(arguments)
    return Config(
        data=given.data,
        out=given.out,
        model=given.model,
        max_effects=given.max_effects,
        candidates=tuple(given.candidates),
        smoke=given.smoke,
        seed=given.seed,
    )


if __name__ == "__main__":
    leave(main, "studies.close_loop")
