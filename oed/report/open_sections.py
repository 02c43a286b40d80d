"""Sections of a diagnosis page on what is open: what has no name, and what to do next."""

from __future__ import annotations

from collections.abc import Sequence

from oed.diagnosis.numbers import NAMED
from oed.report.next_steps import Step
from oed.report.page import Command, Section, Table, Text
from oed.report.table import Row
from oed.report.unnamed_terms import Unnamed

STAND_IN = (
    "An effect is named where its probability is {named:g} or more, its size is told, and held-out recordings "
    "are predicted better with it; here none meets all three. What model.json has instead predicts torque "
    "where the recordings were. A free curve claims no physics, and beyond the range that it was fitted over "
    "it keeps the value of the edge. One noise floor is the standard deviation of the joint's noise."
)
UNTOLD = (
    "What is left here is more than noise, or no noise by its course in time; no effect of the catalogue and "
    "no curve that was tried describes it. One noise floor is the standard deviation of the joint's noise."
)
NEAREST = (
    "Behind: log evidence by which the best description is ahead of the nearest name; at 3 nats it is 20 "
    "times as probable."
)


def unnamed_sections(unnamed: Sequence[Unnamed], labels: Sequence[str], role: str) -> list[Section]:
    """What has no name, if anything.

    Args:
        unnamed: What has none.
        labels: (n,) of the joints.
        role: Of the recordings on which sizes are told.
    """
    if not unnamed:
        return []
    rows: list[Row] = [
        {
            "joint": labels[u.joint],
            "what is there": u.what,
            "the model has": u.model_has,
            "carries [noise floors]": u.carried,
            "error before": u.before,
            "error after": u.after,
            "nearest name": _nearest(u),
        }
        for u in unnamed
    ]
    caption = (
        f"Root mean square on the {role} recordings, errors of the whole joint in noise floors too."
    )
    said = (STAND_IN if any(u.carried is not None for u in unnamed) else UNTOLD).format(named=NAMED)
    blocks = [Text(said), Table(rows, caption, digits=3)]
    if any(u.nearest is not None and u.nearest.behind > 0 for u in unnamed):
        blocks.append(Text(NEAREST))
    return [Section("There, but without a name", blocks)]


def _nearest(unnamed: Unnamed) -> str:
    nearest = unnamed.nearest
    if nearest is None:
        return "none"
    if nearest.behind == 0:
        return f"{nearest.words}, the best description but not certain"
    return f"{nearest.words}, {nearest.behind:.3g} nats behind"


def steps_sections(steps: Sequence[Step]) -> list[Section]:
    """What to do next, if anything is open."""
    blocks: list[Text | Command] = []
    for number, step in enumerate(steps, start=1):
        blocks.append(Text(f"{number}. {step.text}"))
        blocks += [Command("\n".join(step.commands))] if step.commands else []
    return [Section("What to do next", blocks)] if steps else []
