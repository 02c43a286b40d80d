"""The content of diagnosis.json of a diagnosis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oed.diagnosis.diagnose import Diagnosis
from oed.diagnosis.discrimination.next_motion import NextExperiment
from oed.diagnosis.inference.answer import FoundEffect
from oed.report.provenance import Provenance
from oed.report.term_words import TermWords, in_words, words_of_terms
from oed.report.unnamed_terms import unexplained_words

FORMAT = 1
NEXT = "next_experiment"  # folder of the motion that tells alternatives apart


def diagnosis_record(
    found: Diagnosis,
    following: NextExperiment | None,
    *,
    data: str,
    joints: Sequence[str],
    notes: Sequence[str],
    provenance: Provenance,
) -> dict[str, object]:
    """The content of diagnosis.json; `words` say in plain words what a term is."""
    words = words_of_terms(found)
    return {
        "format": FORMAT,
        "data": data,
        "joints": list(joints),
        "data_notes": list(notes),
        "verdict": found.verdict,
        "effects": [_effect(effect, words) for effect in found.effects],
        "unexplained": [
            {
                "joint": u.joint,
                "depends_on": list(u.depends_on),
                "term": u.label,
                "words": unexplained_words(u, words).whole,
            }
            for u in found.unexplained
        ],
        "contradicted": [in_words(text, words) for text in found.contradicted],
        "rms": {
            "before": {e.role: e.before for e in found.errors},
            "after": {e.role: e.after for e in found.errors},
            "noise_floor": {e.role: found.noise_floor for e in found.errors},
            "before_interval": {e.role: e.before_interval for e in found.errors},
            "after_interval": {e.role: e.after_interval for e in found.errors},
            "change_interval": {e.role: e.change_interval for e in found.errors},
            "rows_counted": {e.role: e.counted for e in found.errors},
        },
        "relative_rms": {
            "before": {e.role: e.before / e.torque for e in found.errors},
            "after": {e.role: e.after / e.torque for e in found.errors},
            "noise_floor": {e.role: found.noise_floor / e.torque for e in found.errors},
        },
        "budget": {
            "recordings": found.budget.role,
            "rms": {share.label: share.rms for share in found.budget.shares},
            "words": {
                share.label: words[share.label].whole
                for share in found.budget.shares
                if share.label in words
            },
            "left": found.budget.left,
            "noise_floor": found.budget.floor,
        },
        "noise_source": found.noise_source,
        "band_hz": found.cutoff,
        "next_experiment": None if following is None else NEXT,
        "versions": provenance.versions,
        "commit": provenance.commit,
        "seed": provenance.seed,
    }


def _effect(effect: FoundEffect, words: Mapping[str, TermWords]) -> dict[str, object]:
    return {
        "name": effect.name,
        "joint": effect.joint,
        "probability": effect.probability,
        "log_evidence": effect.nats,
        "held_out_gain": effect.held_out_gain,
        "parameters": {
            # A note says where the recordings tell no standard deviation.
            p.name: {"value": p.value, "std": p.std, "unit": p.unit}
            | ({} if p.note is None else {"note": p.note})
            for p in effect.parameters
        },
        "alternatives": [
            {
                "name": a.name,
                "joint": a.joint,
                "term": a.label,
                "words": words[a.label].whole,
                "probability": a.probability,
                "contender": a.open,
            }
            | ({"same": True} if a.same else {})
            for a in effect.alternatives
        ],
    }
