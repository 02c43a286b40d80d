"""Published C and C++ code of a model, compiled where it lies and called from here.

Nothing of it is copied: the compiler reads the clone, and what it makes goes into the folder of
the run.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.motion import Motion
from oed.errors import OedError
from studies.public_arms.arm import Torque

EIGEN = Path(casadi.__file__).parent / "include"  # CasADi's wheels bring its headers
# Of central differences [rad]: mass matrices may come in single precision, and their shortest wave
# is a radian or so, of which this leaves an error of 1e-6.
STEP = 1e-3
Values = Callable[[Float[ndarray, "samples joints"]], Float[ndarray, "samples values"]]


class NoCompiler(OedError):
    """There is no C++ compiler, or it refused the code."""


@dataclass(frozen=True)
class Library:
    """A compiled library.

    Attributes:
        handle: Of the library.
    """

    handle: ctypes.CDLL

    def call(self, name: str, size: int, *given: Float[ndarray, "samples joints"]) -> ndarray:
        """(N, size) what a function `void name(const double*, ..., double*)` makes of each sample."""
        function = getattr(self.handle, name)
        pointer = ctypes.POINTER(ctypes.c_double)
        function.argtypes, function.restype = [pointer] * (len(given) + 1), None
        inputs = [np.ascontiguousarray(x, dtype=float) for x in given]
        result = np.empty((len(inputs[0]), size))
        for k in range(len(result)):
            function(*(x[k].ctypes.data_as(pointer) for x in (*inputs, result)))
        return result


def compiled(
    sources: Sequence[Path], includes: Sequence[Path], wrapper: str, folder: Path
) -> Library:
    """Compile sources with a wrapper that gives their functions plain C names.

    Args:
        sources: Of the clone.
        includes: Folders of its headers.
        wrapper: C++ text with `extern "C"` functions.
        folder: For the library.

    Raises:
        NoCompiler: If there is no g++, or it does not compile them.
    """
    compiler = shutil.which("g++") or shutil.which("c++")
    if compiler is None:
        raise NoCompiler("no C++ compiler: install g++ to run the published code")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "wrapper.cpp").write_text(wrapper, encoding="utf-8")
    target = folder / "published.so"
    paths = [flag for path in (*includes, EIGEN, EIGEN / "eigen3") for flag in ("-I", str(path))]
    files = [*map(str, sources), str(folder / "wrapper.cpp")]
    # Unoptimised: these are pages of formulas, which an optimiser takes minutes over.
    command = [compiler, "-O0", "-w", "-shared", "-fPIC", *paths, *files, "-o", str(target)]
    # What a clone holds is run because the user named it to be run.
    run = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if run.returncode != 0:
        raise NoCompiler(f"the published code was not compiled: {run.stderr[-300:]}")
    return Library(ctypes.CDLL(str(target)))


def torque_of(library: Library, joints: int) -> Torque:
    """The torque of a wrapper that has `inertia`, `gravity` and `friction` of an arm."""
    return equation_of_motion(
        lambda q: library.call("inertia", joints**2, q),
        lambda q: library.call("gravity", joints, q),
        lambda dq: library.call("friction", joints, dq),
    )


def equation_of_motion(inertia: Values, gravity: Values, friction: Values) -> Torque:
    """The torque of a mass matrix, with the velocity terms that belong to it, gravity and friction.

    Coriolis and centrifugal torques are dM/dt dq - d(dq' M dq / 2)/dq, by central differences.

    Args:
        inertia: (N, n) positions to (N, n * n) mass matrices, rows after one another.
        gravity: (N, n) positions to (N, n) torques.
        friction: (N, n) velocities to (N, n) torques.
    """

    def torque(motion: Motion) -> Float[ndarray, "samples joints"]:
        q, dq = motion.q, motion.dq
        n = q.shape[1]

        def mass(at: Float[ndarray, "samples joints"]) -> Float[ndarray, "samples joints joints"]:
            return inertia(at).reshape(-1, n, n)

        momentum = np.einsum("nij,nj->ni", mass(q), motion.ddq)
        along = (mass(q + STEP * dq) - mass(q - STEP * dq)) / (2 * STEP)
        momentum += np.einsum("nij,nj->ni", along, dq)
        for j, shift in enumerate(STEP * np.eye(n)):
            slope = (mass(q + shift) - mass(q - shift)) / (2 * STEP)
            momentum[:, j] -= np.einsum("ni,nij,nj->n", dq, slope, dq) / 2
        return momentum + gravity(q) + friction(dq)

    return torque
