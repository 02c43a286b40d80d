"""Memory of an estimate grows with the recordings, not with rows times columns."""

import tracemalloc
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from oed.diagnosis.setup import COLUMNS_PER_JOINT, _looked_at
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.estimation.feasible.data_factor import block_factors
from oed.estimation.identify import identify
from oed.estimation.row_pieces import HELD_BYTES, PIECE_BYTES, RowPieces
from oed.estimation.stacking import process_all
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.settings import choose_settings
from oed.experiment.recording import Recording, Role
from oed.robot import imi_scara

JOINTS = 2
PIECE = 250  # samples
COLUMNS = 40
GIGABYTE = 1e9


def peak(work: Callable[[], object]) -> int:
    """Most memory in use at once while something is done [bytes]."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def growth(peak_of: Callable[[int], int], few: int, many: int) -> float:
    """Bytes that each further sample takes."""
    return (peak_of(many) - peak_of(few)) / (many - few)


def identified(samples: int, most: int) -> int:
    """Peak while `samples` of two joints are fitted, of whose rows so many bytes are held."""
    rng = np.random.default_rng(0)
    truth, count = rng.standard_normal(COLUMNS), samples // PIECE

    def piece(number: int) -> np.ndarray:
        return np.random.default_rng(number).standard_normal((2 * PIECE, COLUMNS))

    rows = RowPieces(
        tuple(partial(piece, number) for number in range(count)), (PIECE,) * count, 2, COLUMNS
    )
    tau = rows.predict(truth) + 0.1 * rng.standard_normal((samples, 2))
    names = tuple(f"p{k}" for k in range(COLUMNS))
    return peak(lambda: identify(rows.held(most), tau, names, ("1",) * COLUMNS))


def test_no_more_rows_are_held_than_is_said() -> None:
    a_sample = 8 * 2 * COLUMNS
    held = growth(partial(identified, most=HELD_BYTES), 1000, 3000)
    assert held > a_sample  # short recordings are held whole
    assert growth(partial(identified, most=0), 1000, 3000) < a_sample / 3
    # What is held, and the half dozen arrays of a pass, leave half of two gigabytes to all else.
    assert HELD_BYTES + 6 * PIECE_BYTES < GIGABYTE


def long_log(samples: int) -> DataSet:
    robot = imi_scara()
    model = build_model("standard", robot)
    rng = np.random.default_rng(1)
    w, a = 2 * np.pi * rng.uniform(0.1, 0.6, (2, 3)), rng.uniform(0.1, 0.3, (2, 3))
    t = 0.01 * np.arange(samples)
    phase = t[:, None, None] * w + rng.uniform(0, 6, (2, 3))
    motion = Motion(
        t,
        (a * np.sin(phase)).sum(2),
        (a * w * np.cos(phase)).sum(2),
        (-a * w**2 * np.sin(phase)).sum(2),
    )
    torque = model.torque(np.append(robot.parameters, [0.5] * 4), motion)
    torque += 0.05 * rng.standard_normal(torque.shape)
    parts: list[tuple[str, Role, slice]] = [
        ("fit", "estimation", slice(0, 2 * samples // 3)),
        ("held", "validation", slice(2 * samples // 3, samples)),
    ]
    recordings = tuple(
        Recording(name, role, t[part] - t[part][0], motion.q[part], torque[part])
        for name, role, part in parts
    )
    return DataSet("long", "tests", "none", robot, "measured", recordings=recordings)


def test_a_feasible_fit_holds_factors_and_no_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("oed.experiment.preparation.processed.PIECE", 500)

    def factored(samples: int) -> int:
        dataset = long_log(samples)
        model = build_model("standard", dataset.robot)
        recordings = process_all(dataset, choose_settings(dataset.recordings))["estimation"]
        return peak(lambda: block_factors(model, recordings, blocks=20))

    a_sample = 8 * JOINTS * len(build_model("standard", imi_scara()).parameters)
    assert growth(factored, 3000, 12_000) < a_sample / 3


def test_a_diagnosis_looks_at_as_many_rows_as_fits_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    most = 2500
    monkeypatch.setattr(
        "oed.diagnosis.setup.FIT_BYTES", 8 * JOINTS * COLUMNS_PER_JOINT * JOINTS * most
    )
    for samples in (8000, 16_000):
        recordings, told = long_log(samples).recordings, []
        prepared = prepare(recordings, choose_settings(recordings))
        looked_at = sum(p.rows for each in _looked_at(prepared, told.append) for p in each)
        assert 0.8 * most < looked_at <= most
        assert f" {looked_at} are looked at" in told[0]
