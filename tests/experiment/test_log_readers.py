"""Readers of log files: one registry, that a user's own code extends."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from oed.errors import DataSetError
from oed.experiment.logs import read_log
from oed.experiment.read_dataset import read_dataset
from tests.experiment.tiny_dataset import MANIFEST, tiny_files, write_files

OWN_READER = """
import json
from pathlib import Path
import numpy as np
from oed.experiment.logs import Log, log_reader, table_of
from oed.experiment.read_dataset import read_dataset

@log_reader(".jsonlog")
def read_json_log(path: Path) -> Log:
    arrays = {key: np.array(value) for key, value in json.loads(path.read_text()).items()}
    return Log(str(path), (table_of(arrays, str(path)),))

print(json.dumps(read_dataset({folder!r}).test[0].tau.tolist()))
"""


def test_a_reader_registered_from_outside_is_used(tmp_path):
    files = tiny_files()
    plain = read_dataset(write_files(tmp_path / "plain", files)).test[0]
    table = np.loadtxt(files["test.csv"].decode().splitlines(), delimiter=",", skiprows=1)
    columns = dict(zip(("t", "q_1", "q_2", "tau_1", "tau_2"), table.T.tolist(), strict=True))
    del files["test.csv"]
    files["test.jsonlog"] = json.dumps(columns).encode()
    files["dataset.toml"] = MANIFEST.replace("test.csv", "test.jsonlog").encode()
    folder = write_files(tmp_path / "own", files)
    with pytest.raises(DataSetError, match="not known"):
        read_dataset(folder)
    # In a process of its own: a registration lasts.
    code = OWN_READER.replace("{folder!r}", repr(str(folder)))
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert np.array_equal(json.loads(run.stdout), plain.tau)


@pytest.mark.parametrize("name", ["log.docx", "log", "absent.csv", "absent.db3", "folder"])
def test_what_is_no_log(tmp_path, name):
    (tmp_path / "log.docx").write_bytes(b"x")
    (tmp_path / "log").write_bytes(b"x")
    (tmp_path / "folder").mkdir()
    with pytest.raises(DataSetError) as caught:
        read_log(Path(tmp_path / name))
    assert caught.value.file.endswith(name)
