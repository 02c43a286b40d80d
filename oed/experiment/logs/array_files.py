"""Files of named arrays: NumPy .npz, MATLAB .mat of any version, HDF5.

Arrays with one number or one list a row are the columns; those of one length are one table. Files
that are cut or altered fail in these libraries in countless ways, all of which mean the same here.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy import ndarray

from oed.errors import DataSetError
from oed.experiment.logs.mat_check import check_mat
from oed.experiment.logs.registry import log_reader
from oed.experiment.logs.table import Log, table_of
from oed.input_file import too_many_numbers

HDF5_START = b"\x89HDF\r\n\x1a\n"
# MATLAB 7.3 writes 512 bytes of its own before the HDF5 file.
HDF5_AT = (0, 512)


@log_reader(".npz")
def read_npz(path: Path) -> Log:
    """Read a NumPy archive; nothing pickled is loaded."""
    try:
        # In memory: of a file that it cannot read, NumPy leaves the handle open.
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as archive:
            _check_room(sum(part.file_size for part in archive.zip.infolist()) // 8, path)
            arrays = {name: archive[name] for name in archive.files}
    except DataSetError:
        raise
    except Exception as error:
        raise DataSetError(f"is no sound NumPy archive: {error}", file=str(path)) from error
    return _log(arrays, path)


@log_reader(".mat")
def read_mat(path: Path) -> Log:
    """Read a MATLAB file of version 4 to 7.3; fields of a struct are named `struct.field`."""
    from scipy.io import loadmat  # noqa: PLC0415  a quarter of a second that only .mat files need

    try:
        content = path.read_bytes()
        if any(content[at:].startswith(HDF5_START) for at in HDF5_AT):
            return _log(_hdf5_arrays(path, is_matlab=True), path)
        check_mat(content)
        loaded = loadmat(io.BytesIO(content), squeeze_me=False, struct_as_record=True)
    except DataSetError:
        raise
    except Exception as error:
        raise DataSetError(f"is no sound MATLAB file: {error}", file=str(path)) from error
    own = {name: value for name, value in loaded.items() if not name.startswith("__")}
    return _log(dict(_fields("", own)), path)


@log_reader(".h5", ".hdf5")
def read_hdf5(path: Path) -> Log:
    """Read an HDF5 file; a data set within groups is named by its path."""
    try:
        return _log(_hdf5_arrays(path, is_matlab=False), path)
    except DataSetError:
        raise
    except Exception as error:
        raise DataSetError(f"is no sound HDF5 file: {error}", file=str(path)) from error


def _hdf5_arrays(path: Path, *, is_matlab: bool) -> dict[str, ndarray]:
    import h5py  # noqa: PLC0415  only HDF5 files need it

    arrays: dict[str, ndarray] = {}

    def visit(name: str, item: object) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith("#"):
            return
        if item.dtype.kind in "iuf":
            # MATLAB stores columns first, so that an array comes out transposed.
            arrays[name.replace("/", ".")] = (
                np.asarray(item[()]).T if is_matlab else np.asarray(item[()])
            )
        elif item.dtype.names:
            record = item[()]
            for field in item.dtype.names:
                arrays[f"{name}.{field}".replace("/", ".")] = np.asarray(record[field])

    def measure(_: str, item: object) -> None:
        sizes.append(int(item.size or 0) if isinstance(item, h5py.Dataset) else 0)

    with h5py.File(path, "r") as file:
        sizes: list[int] = []
        file.visititems(measure)
        _check_room(sum(sizes), path)
        file.visititems(visit)
    return arrays


def _check_room(count: int, path: Path) -> None:
    """Refuse what would not fit into memory: packed, it may take no room in the file."""
    reason = too_many_numbers(count)
    if reason:
        raise DataSetError(reason, file=str(path))


def _fields(prefix: str, content: Mapping[str, object]) -> Iterator[tuple[str, ndarray]]:
    """Arrays of numbers, those within structs of one element included."""
    for name, value in content.items():
        array = np.asarray(value)
        if array.dtype.names and array.size == 1:
            struct = array.reshape(-1)[0]
            inner = {field: struct[field] for field in array.dtype.names}
            yield from _fields(f"{prefix}{name}.", inner)
        elif array.dtype.kind in "iuf":
            yield prefix + name, array


def _log(arrays: Mapping[str, ndarray], path: Path) -> Log:
    """Arrays by their number of rows, the longest table first."""
    file = str(path)
    numeric = {
        k: _upright(v) for k, v in arrays.items() if v.dtype.kind in "iuf" and v.ndim in (1, 2)
    }
    lengths = sorted({len(v) for v in numeric.values() if v.size > 1}, reverse=True)
    tables = tuple(
        table_of({k: v for k, v in numeric.items() if len(v) == length}, file) for length in lengths
    )
    if not tables:
        raise DataSetError("holds no array of numbers with a row per sample", file=file)
    return Log(file, tables)


def _upright(array: ndarray) -> ndarray:
    """(N,) or (N, m) with a row per sample: a log has more samples than joints."""
    if array.ndim == 2 and array.shape[0] < array.shape[1]:
        array = array.T
    return array[:, 0] if array.ndim == 2 and array.shape[1] == 1 else array
