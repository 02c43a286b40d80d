"""Spoiled files of arrays: refused before a library that believes them ends the process."""

import io
import subprocess
import sys
import warnings
import zlib
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scipy.io.matlab
from scipy.io import loadmat, savemat

from oed.errors import DataSetError
from oed.experiment.logs import read_log
from oed.experiment.logs.mat_check import DEEPEST, check_mat

ROWS = 30
# Written by MATLAB 4 to 7.4 on four kinds of machines, and some that are spoiled.
MATLAB_FILES = sorted((Path(scipy.io.matlab.__file__).parent / "tests" / "data").glob("*.mat"))
READ = """
import sys
from pathlib import Path
from oed.errors import DataSetError
from oed.experiment.logs import read_log
for path in sys.argv[1:]:
    try:
        read_log(Path(path))
    except DataSetError as error:
        print(error)
"""


def mat_file(*, packed: bool = False) -> bytes:
    file = io.BytesIO()
    log = {"t": np.arange(float(ROWS)), "note": "run 3", "cell": np.array([1, "a"], dtype=object)}
    savemat(file, {"log": log, "z": np.array([1 + 2j])}, do_compression=packed)
    return file.getvalue()


def tag(kind: int, size: int) -> bytes:
    return kind.to_bytes(4, "little") + size.to_bytes(4, "little")


NUMBERS = tag(9, 8 * ROWS)  # of `t`
WORD = tag(5, 8) + (1).to_bytes(4, "little") + (5).to_bytes(4, "little")  # dimensions of `note`
SPOILED = {
    "an array for numbers": (NUMBERS, tag(14, 8 * ROWS)),
    "a type that there is not": (NUMBERS, tag(4711, 8 * ROWS)),
    "more bytes than there are": (NUMBERS, tag(9, 1 << 30)),
    "letters without dimensions": (WORD, tag(5, 0)),
    "negative dimensions": (WORD, WORD[:8] + b"\xff" * 8),
    "many cells": (
        tag(5, 8) + bytes([1, 0, 0, 0, 2, 0, 0, 0]),
        tag(5, 8) + b"\xff\xff\xff\x0f" * 2,
    ),
}


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("fault", SPOILED)
def test_a_tag_that_says_what_cannot_be_is_refused(fault, packed):
    old, new = SPOILED[fault]
    content = mat_file()
    assert content.count(old) >= 1
    spoiled = content.replace(old, new, 1)
    if packed:
        body = zlib.compress(spoiled[128:])
        spoiled = spoiled[:128] + tag(15, len(body)) + body
    with pytest.raises(ValueError, match=r"element|dimensions|arrays"):
        check_mat(spoiled)


def test_structs_without_an_end_are_refused():
    deep: object = 1.0
    for _ in range(DEEPEST + 2):
        deep = {"a": deep}
    content = io.BytesIO()
    savemat(content, {"deep": deep})
    with pytest.raises(ValueError, match="within one another"):
        check_mat(content.getvalue())


def test_a_spoiled_file_does_not_end_the_process(tmp_path):
    paths = []
    for i, fault in enumerate(("an array for numbers", "letters without dimensions")):
        paths.append(tmp_path / f"{i}.mat")
        paths[-1].write_bytes(mat_file().replace(*SPOILED[fault], 1))
    run = subprocess.run(
        [sys.executable, "-c", READ, *map(str, paths)], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0
    assert run.stdout.count("is no sound MATLAB file") == len(paths)


@pytest.mark.parametrize("packed", [False, True])
def test_a_sound_file_passes(packed):
    check_mat(mat_file(packed=packed))


@pytest.mark.skipif(not MATLAB_FILES, reason="SciPy is installed without its tests")
def test_what_matlab_wrote_passes():
    """What is refused of SciPy's own collection, SciPy refuses too."""
    refused = set()
    for path in MATLAB_FILES:
        content = path.read_bytes()
        try:
            check_mat(content)
        except ValueError:
            refused.add(path.name)
            with warnings.catch_warnings(action="ignore"), pytest.raises(Exception):  # noqa: B017, PT011
                loadmat(path)
    assert len(refused) < 0.1 * len(MATLAB_FILES)


def test_a_table_of_other_rows_than_its_file_says_is_refused(tmp_path):
    file = io.BytesIO()
    lists = pa.array(np.ones((ROWS, 2)).tolist(), pa.list_(pa.float64(), 2))
    pq.write_table(pa.table({"t": np.arange(float(ROWS)), "q": lists}), file)
    content, said = file.getvalue(), []
    # Whole numbers stand there doubled.
    for at in (i for i, byte in enumerate(content) if byte == 2 * ROWS):
        path = tmp_path / "log.parquet"
        path.write_bytes(content[:at] + b"\0" + content[at + 1 :])
        try:
            table = read_log(path).tables[0]
            assert all(len(table.read([name])[name]) == ROWS for name in table.columns)
        except DataSetError as error:
            said.append(str(error))
    assert any(f"it says {ROWS} rows and holds 0" in line for line in said)
