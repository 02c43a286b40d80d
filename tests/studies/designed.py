"""A quick design that must succeed, and what its file says of the motion."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.robot import imi_scara
from tests.running import oed


def designed(out: Path, *wishes: str) -> tuple[dict, pd.DataFrame]:
    """The record and the motion of a quick design that must succeed."""
    assert oed("design", *wishes, "--out", str(out), "--smoke") == 0
    return json.loads((out / "design.json").read_text()), pd.read_csv(out / "motion.csv")


def experiment_information(record: dict) -> np.ndarray:
    """H^T H at the instants of a design file, from its coefficients by the textbook's series."""
    model = TorqueModel.standard(imi_scara())
    series = {key: np.array(value) for key, value in record["coefficients"].items()}
    t = np.arange(record["instants"]) * record["horizon"] / record["instants"]
    k = np.arange(1, series["sine"].shape[1] + 1) * 2 * np.pi / record["horizon"]
    sine, cosine = np.sin(np.outer(t, k)), np.cos(np.outer(t, k))
    q = series["offset"] + sine @ series["sine"].T + cosine @ series["cosine"].T
    dq = (cosine * k) @ series["sine"].T - (sine * k) @ series["cosine"].T
    ddq = -(sine * k**2) @ series["sine"].T - (cosine * k**2) @ series["cosine"].T
    base = base_parameters(model)
    H = base.reduce(model.regressor(Motion(t, q, dq, ddq))).reshape(-1, len(base))
    return H.T @ H


def log10_det(information: np.ndarray) -> float:
    return np.linalg.slogdet(information)[1] / np.log(10)
