"""What comes in its own time."""

from __future__ import annotations

from oed.diagnosis.evidence.differing import differing, left_of_single
from oed.diagnosis.evidence.final_model import FinalModel
from oed.diagnosis.evidence.free_running import find_lines
from oed.diagnosis.evidence.modulation import find_modulations
from oed.diagnosis.evidence.verdict import Unexplained
from oed.diagnosis_new.noise.baseline import Baseline
from oed.experiment.preparation.prepared import Prepared


def in_own_time(
    after: FinalModel, by_role: dict[str, tuple[Prepared, ...]], baseline: Baseline
) -> tuple[Unexplained, ...]:
    """What comes in its own time: with the state of the arm, or without."""
    estimation = by_role["estimation"]
    band, recordings = estimation[0].band, differing(after, estimation, baseline)
    modulations = find_modulations(recordings, band.analysis_rate)
    carried = {m.joint for m in modulations}
    if not recordings:
        recordings = left_of_single(after, (*estimation, *by_role["validation"]), baseline)
    lines = find_lines(recordings, band.analysis_rate, band.cutoff)
    return (
        *(
            Unexplained(m.joint, m.depends_on, m.share, m.label, stands_in=False)
            for m in modulations
        ),
        *(
            Unexplained(x.joint, ("time",), x.share, x.label, stands_in=False)
            for x in lines
            if x.joint not in carried
        ),
    )
