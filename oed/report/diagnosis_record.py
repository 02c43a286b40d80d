"""The content of diagnosis.json."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.diagnosis.diagnosis import Diagnosis
from oed.diagnosis.evidence.verdict import FoundEffect
from oed.diagnosis.rivals.discrimination import NextExperiment
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.effects.payload import PayloadChange
from oed.report.effect_words import known_parameters
from oed.report.provenance import Provenance

FORMAT = 1
NEXT = "next_experiment"


def diagnosis_record(
    found: Diagnosis,
    following: NextExperiment | None,
    *,
    data: str,
    joints: Sequence[str],
    notes: Sequence[str],
    settings: DiagnosisSettings,
    provenance: Provenance,
) -> dict[str, object]:
    """The content of diagnosis.json."""
    return {
        "format": FORMAT,
        "data": data,
        "joints": list(joints),
        "data_notes": list(notes),
        "verdict": found.verdict,
        "effects": [_effect(effect, found) for effect in found.effects],
        "unexplained": [
            {
                "joint": u.joint,
                "depends_on": list(u.depends_on),
                "share": u.share,
                "term": u.label,
                "stands_in": u.stands_in,
            }
            for u in found.unexplained
        ],
        "rms": {
            "before": {p.role: p.before for p in found.proof},
            "after": {p.role: p.after for p in found.proof},
            "noise_floor": {p.role: found.noise_floor for p in found.proof},
            # That noise, and parameters which it leaves uncertain, let expect.
            "expected": {
                p.role: found.expected * found.noise_floor
                for p in found.proof
                if p.role == "validation"
            },
            # Of all that was found, where the test recordings then took something of it back.
            "unchecked": {} if found.unchecked is None else {"test": found.unchecked},
            "before_interval": {p.role: p.before_interval for p in found.proof},
            "after_interval": {p.role: p.after_interval for p in found.proof},
            "change_interval": {p.role: p.change_interval for p in found.proof},
            # Rows where the direction of motion is uncertain count less: share that is left.
            "rows_counted": {p.role: p.counted for p in found.proof},
        },
        "relative_rms": {
            "before": {p.role: p.before / p.torque for p in found.proof},
            "after": {p.role: p.after / p.torque for p in found.proof},
            "noise_floor": {p.role: found.noise_floor / p.torque for p in found.proof},
        },
        "lack_of_fit": {
            "before": {"ratio": found.lack_before.ratio, "p_value": found.lack_before.p_value},
            "after": {"ratio": found.lack_after.ratio, "p_value": found.lack_after.p_value},
        },
        "noise_source": found.noise_source,
        "band_hz": found.cutoff,
        "refused": list(found.refused),
        "next_experiment": None if following is None else NEXT,
        "settings": settings,
        "versions": provenance.versions,
        "commit": provenance.commit,
        "seed": settings.seed,
    }


def _effect(effect: FoundEffect, found: Diagnosis) -> dict[str, object]:
    known = known_parameters(effect, found.shop.context, found.before.model.robot.joints)
    record: dict[str, object] = {
        "name": effect.name,
        "joint": effect.joint,
        "parameters": {
            # A note says where the standard deviation is no measurement.
            p.name: {"value": p.value, "std": p.std, "unit": p.unit}
            | ({} if p.note is None else {"note": p.note})
            | ({} if p.stands_for is None else {"stands_for": p.stands_for})
            for p in known
        },
        "p_value": effect.p_value,
        "validation_gain": effect.validation_gain,
        "alternatives": [
            {"name": r.name, "joint": r.joint, "evidence": r.evidence, "contender": r.contender}
            | ({"same": True} if r.is_same else {})
            for r in effect.rivals
        ],
    }
    if isinstance(effect.trial.effect, PayloadChange) and found.moments:
        record["moments"] = _moments(found)
    return record


def _moments(found: Diagnosis) -> dict[str, object]:
    """When each further recording takes the load up; null where it never does."""
    return {
        name: {"value": m.value, "std": m.std, "unit": m.unit} if np.isfinite(m.value) else None
        for name, m in found.moments.items()
    }
