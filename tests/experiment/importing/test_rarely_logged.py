"""A quantity that a log can be read without, and hardly holds, is left out of an import and said."""

import numpy as np
import pandas as pd
import pytest

from oed.errors import DataSetError
from oed.experiment.importing.import_log import ImportChoices, propose_import
from oed.robot import load_robot
from tests.experiment.importing.laboratory_logs import simulate


@pytest.fixture(scope="module")
def plain(arm) -> pd.DataFrame:
    truth = simulate(load_robot(arm), rows=300)
    columns = {"time": truth.t}
    for name, values in (("q", truth.q), ("tau", truth.tau)):
        columns |= {f"{name}_{j + 1}": values[:, j] for j in range(3)}
    return pd.DataFrame(columns)


def proposed(frames, arm, folder, **choices):
    logs = [folder / f"{i}.csv" for i in range(len(frames))]
    for log, frame in zip(logs, frames, strict=True):
        frame.to_csv(log, index=False)
    return propose_import(logs, ImportChoices(str(arm), name="set", **choices), folder / "set")


def with_rare(plain, quantity, every):
    """With columns of a quantity, of which the second holds a number now and then; never if 0."""
    columns = {f"{quantity}_{j}": 20.0 + plain["time"] for j in (1, 2, 3)}
    frame = plain.assign(**columns)
    rare = np.arange(len(plain)) % every != 0 if every else np.full(len(plain), fill_value=True)
    frame.loc[rare, f"{quantity}_2"] = np.nan
    return frame


@pytest.mark.parametrize("quantity", ["dq", "ddq", "temperature"])
@pytest.mark.parametrize("every", [0, 10])
def test_the_import_is_that_of_the_log_without_it(plain, quantity, every, arm, tmp_path):
    expected = proposed([plain], arm, tmp_path)
    found = proposed([with_rare(plain, quantity, every)], arm, tmp_path)
    assert found.content["columns"] == expected.content["columns"]
    for one, other in zip(found.dataset.recordings, expected.dataset.recordings, strict=True):
        assert np.array_equal(one.t, other.t)
        assert np.array_equal(one.tau, other.tau)
    (note,) = (note for note in found.notes if note.startswith(f"{quantity}: left out"))
    lacking = 270 if every else 300
    assert f"column {quantity}_2 holds no number in {lacking} of 300 rows" in note


def test_it_is_left_out_of_every_log(plain, arm, tmp_path):
    whole = plain.assign(**{f"temperature_{j}": 20.0 + plain["time"] for j in (1, 2, 3)})
    both = [whole, with_rare(plain, "temperature", 10)]
    found = proposed(both, arm, tmp_path, roles=("estimation", "test"))
    assert all(one.temperature is None for one in found.dataset.recordings)


def test_it_is_refused_where_it_was_named(plain, arm, tmp_path):
    named = {"temperature": ("temperature_1", "temperature_2", "temperature_3")}
    with pytest.raises(DataSetError, match="logged at another rate; leave this column out"):
        proposed([with_rare(plain, "temperature", 10)], arm, tmp_path, columns=named)
