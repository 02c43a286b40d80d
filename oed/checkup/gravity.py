"""Whether the declared gravity is the one that the arm feels, in size and direction.

Gravity is not lost in the masses: a link's first moment is in the torque of its weight and in that of its
acceleration, so that a wrong factor leaves a misfit that no masses repair.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from oed.checkup.finding import EvidenceRow, Finding, Level
from oed.checkup.repair import VERY_STRONG, halves
from oed.checkup.suspicion import STANDARD_GRAVITY, is_on_earth
from oed.checkup.trial import Outcome, Trial, trial_data
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.processed import ProcessedRecording
from oed.experiment.recording import Role


def gravity_finding(
    dataset: DataSet,
    model: TorqueModel,
    recordings: Mapping[Role, tuple[ProcessedRecording, ...]],
) -> Finding:
    """Held-out error with gravity as declared, reversed, and of the size that it has on Earth.

    Args:
        dataset: As read.
        model: Of its robot.
        recordings: By role, processed; a thinned rate will do.
    """
    declared = np.asarray(dataset.robot.gravity, dtype=float)
    size = float(np.linalg.norm(declared))
    topic = "gravity"
    if size == 0:
        return Finding(topic, "green", "gravity is declared to be zero")
    is_earths = is_on_earth(declared)
    tried = {"as declared": declared, "reversed": -declared}
    if not is_earths:
        tried["of the size on Earth"] = declared * STANDARD_GRAVITY / size
        tried["of the size on Earth, reversed"] = -declared * STANDARD_GRAVITY / size
    outcomes = {
        name: _outcome(model.with_robot(model.robot.with_gravity(g)), recordings)
        for name, g in tried.items()
    }
    errors = {name: float(np.exp(np.mean(np.log(o.relative)))) for name, o in outcomes.items()}
    rows: tuple[EvidenceRow, ...] = tuple(
        {
            "gravity": name,
            "[m/s^2]": ", ".join(f"{x:.4g}" for x in tried[name]),
            "held-out error / torque": errors[name],
            "2 log likelihood against declared": outcomes["as declared"].deviance - o.deviance,
        }
        for name, o in outcomes.items()
    )
    best = min(outcomes, key=lambda name: outcomes[name].deviance)
    gain = outcomes["as declared"].deviance - outcomes[best].deviance
    # As of any cause that is named: what only makes a bad fit a little less bad is none.
    is_told = gain > VERY_STRONG and halves(outcomes[best], outcomes["as declared"])
    vector = ", ".join(f"{x:.4g}" for x in tried[best])
    evidence = (
        f"the held-out error is {errors['as declared']:.3g} of the torque as declared and "
        f"{errors[best]:.3g} with [{vector}] (2 log likelihood ratio {gain:.3g})"
    )
    if not is_earths:
        ratio = size / STANDARD_GRAVITY
        text = f"the declared gravity of {size:.4g} m/s^2 is {ratio:.3g} times that on Earth"
        told = f"{text}; {evidence}" if is_told else f"{text}; the log alone does not contradict it"
        remedy = f"declare gravity = [{vector}] in dataset.toml, in m/s^2" if is_told else ""
        level: Level = "red" if is_told else "amber"
        return Finding(topic, level, told, remedy, rows)
    if is_told:
        text = f"the declared gravity is reversed: {evidence}"
        return Finding(topic, "red", text, f"declare gravity = [{vector}]", rows)
    return Finding(topic, "green", "the declared gravity fits the log", "", rows)


def _outcome(
    model: TorqueModel, recordings: Mapping[Role, tuple[ProcessedRecording, ...]]
) -> Outcome:
    """Of the log as it is."""
    data = trial_data(recordings, model.columns, remembers=model.remembers)
    return data.outcome(Trial.unchanged(model.robot.n))
