"""Machine code for CasADi functions of scalars, evaluated at many instants at once.

CasADi's own C generator writes one instant; its instruction list, written out with the
compiler's vector type instead, evaluates four instants in each instruction, which is what
brings the regressor to the speed of hand-written rigid-body code.
"""

from __future__ import annotations

import ctypes
import hashlib
import logging
import os
import platform
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import casadi
import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.private_cache import find_whole, private_folder, whole_name

logger = logging.getLogger(__name__)

Batch = Callable[[Float[ndarray, "inputs samples"]], Float[ndarray, "outputs samples"]]

LANES = 4  # doubles of one 256-bit register; compilers split it where there is none
COMPILERS = ("cc", "gcc", "clang")
# -O1: a straight line of thousands of statements gains nothing from more, and costs 5 times
# the time to compile. FLAGS_NATIVE is tried first: it lets the compiler use this CPU in full.
FLAGS = ("-O1", "-fPIC", "-shared", "-fno-math-errno")
FLAGS_NATIVE = ("-march=native", "-mprefer-vector-width=256")
COMPILE_SECONDS = 120.0

PRELUDE = f"""#include <math.h>
#include <string.h>
typedef double v __attribute__((vector_size({8 * LANES})));
static inline v load(const double *p) {{ v a; memcpy(&a, p, sizeof a); return a; }}
static inline void store(double *p, v a) {{ memcpy(p, &a, sizeof a); }}
static inline v all(double c) {{ v a; for (int i = 0; i < {LANES}; i++) a[i] = c; return a; }}
"""

# Operations of the vector type itself, and those done lane by lane.
WIDE = {
    casadi.OP_ASSIGN: "{0}",
    casadi.OP_ADD: "{0} + {1}",
    casadi.OP_SUB: "{0} - {1}",
    casadi.OP_MUL: "{0} * {1}",
    casadi.OP_DIV: "{0} / {1}",
    casadi.OP_NEG: "-{0}",
    casadi.OP_SQ: "{0} * {0}",
    casadi.OP_TWICE: "{0} + {0}",
    casadi.OP_INV: "1.0 / {0}",
}
LANEWISE = {
    casadi.OP_EXP: "exp(x)",
    casadi.OP_LOG: "log(x)",
    casadi.OP_SQRT: "sqrt(x)",
    casadi.OP_SIN: "sin(x)",
    casadi.OP_COS: "cos(x)",
    casadi.OP_TAN: "tan(x)",
    casadi.OP_ASIN: "asin(x)",
    casadi.OP_ACOS: "acos(x)",
    casadi.OP_ATAN: "atan(x)",
    casadi.OP_SINH: "sinh(x)",
    casadi.OP_COSH: "cosh(x)",
    casadi.OP_TANH: "tanh(x)",
    casadi.OP_FABS: "fabs(x)",
    casadi.OP_SIGN: "(x > 0) - (x < 0)",
    casadi.OP_FLOOR: "floor(x)",
    casadi.OP_NOT: "!x",
    casadi.OP_POW: "pow(x, y)",
    casadi.OP_CONSTPOW: "pow(x, y)",
    casadi.OP_ATAN2: "atan2(x, y)",
    casadi.OP_FMIN: "fmin(x, y)",
    casadi.OP_FMAX: "fmax(x, y)",
    casadi.OP_LT: "x < y",
    casadi.OP_LE: "x <= y",
    casadi.OP_EQ: "x == y",
    casadi.OP_NE: "x != y",
    casadi.OP_AND: "x && y",
    casadi.OP_OR: "x || y",
    casadi.OP_IF_ELSE_ZERO: "x ? y : 0",
}


def native_function(functions: Sequence[casadi.Function]) -> tuple[Batch, ...] | None:
    """Compile functions of one vector to batch versions, one row a scalar.

    Args:
        functions: Each of one dense input and one output, built from SX.

    Returns:
        Functions from (inputs, N) to (outputs, N) arrays; None where there is no compiler, or
        it refuses, or an operation is not known here. The reason goes to the log.
    """
    try:
        sources = [_source(function, f"f{i}") for i, function in enumerate(functions)]
    except NotImplementedError as error:
        logger.warning("no machine code: %s", error)
        return None
    library = _library(PRELUDE + "".join(sources))
    if library is None:
        return None
    return tuple(_batch(library, f"f{i}", f) for i, f in enumerate(functions))


def _source(function: casadi.Function, name: str) -> str:
    """C of a loop over blocks of `LANES` instants; arrays have one row a scalar."""
    helpers: dict[int, str] = {}
    lines: list[str] = []
    # Work registers are reused by CasADi; a fresh name for each value helps the compiler.
    latest: dict[int, str] = {}
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        inputs, outputs = function.instruction_input(k), function.instruction_output(k)
        if operation == casadi.OP_OUTPUT:
            lines.append(f"store(y + {outputs[1]} * n + k, {latest[inputs[0]]});")
            continue
        if operation == casadi.OP_INPUT:
            value = f"load(x + {inputs[1]} * n + k)"
        elif operation == casadi.OP_CONST:
            value = f"all({_literal(function.instruction_constant(k))})"
        else:
            value = _operation(operation, [latest[i] for i in inputs], name, helpers)
        latest[outputs[0]] = f"a{k}"
        lines.append(f"const v a{k} = {value};")
    body = "\n".join(lines)
    return (
        "".join(helpers.values())
        + f"void {name}(const double *restrict x, double *restrict y, long n) {{\n"
        + f"for (long k = 0; k < n; k += {LANES}) {{\n{body}\n}}}}\n"
    )


def _operation(operation: int, operands: list[str], name: str, helpers: dict[int, str]) -> str:
    if operation in WIDE:
        return WIDE[operation].format(*operands)
    if operation not in LANEWISE:
        raise NotImplementedError(f"operation {operation} of CasADi has no C here")
    helper = f"{name}_op{operation}"
    arguments = ", ".join(f"v {symbol}s" for symbol in "xy"[: len(operands)])
    lanes = " ".join(f"double {s} = {s}s[i];" for s in "xy"[: len(operands)])
    helpers[operation] = (
        f"static v {helper}({arguments}) {{ v r; "
        f"for (int i = 0; i < {LANES}; i++) {{ {lanes} r[i] = {LANEWISE[operation]}; }} "
        "return r; }\n"
    )
    return f"{helper}({', '.join(operands)})"


def _literal(value: float) -> str:
    if np.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return "NAN" if np.isnan(value) else repr(float(value))


def _library(source: str) -> ctypes.CDLL | None:
    """The compiled source, from the cache where it is there."""
    compiler = _compiler()
    if compiler is None:
        logger.warning("no C compiler found: CasADi's virtual machine is used, 5 times slower")
        return None
    cache = private_folder("native")
    for flags in ((*FLAGS, *FLAGS_NATIVE), FLAGS):
        text = "\n".join((source, compiler, *flags, platform.machine(), _cpu()))
        key = hashlib.sha256(text.encode()).hexdigest()[:32]
        known = find_whole(cache, key, ".so") if cache is not None else None
        library = _load(known) if known is not None else None
        library = library or _compile(source, (compiler, *flags), cache, key)
        if library is not None:
            return library
    return None


def _load(path: Path) -> ctypes.CDLL | None:
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        logger.warning("compiled code cannot be loaded: %s", error)
        return None


def _compiler() -> str | None:
    candidates = (os.environ.get("CC"), *COMPILERS)
    return next((found for c in candidates if c and (found := shutil.which(c))), None)


def _cpu() -> str:
    """What -march=native depends on, so that a shared cache never serves another CPU."""
    info = Path("/proc/cpuinfo")
    if not info.is_file():
        return platform.processor()
    lines = info.read_text(errors="replace").splitlines()
    return next((line for line in lines if line.startswith(("flags", "Features"))), "")


def _compile(
    source: str, command: Sequence[str], cache: Path | None, key: str
) -> ctypes.CDLL | None:
    """Compile, keep the library in the cache if there is one, and load it."""
    try:
        with tempfile.TemporaryDirectory(dir=cache) as scratch:
            text, built = Path(scratch) / "code.c", Path(scratch) / "code.so"
            text.write_text(source)
            whole = [*command, "-o", str(built), str(text), "-lm"]
            subprocess.run(whole, check=True, capture_output=True, timeout=COMPILE_SECONDS)  # noqa: S603  # a fixed command on our own source
            if cache is None:
                return _load(built)  # once loaded, a library outlives its file
            built.chmod(0o700)
            target = cache / whole_name(key, built.read_bytes(), ".so")
            built.replace(target)  # atomic: another process may build the same
            return _load(target)
    except (OSError, subprocess.SubprocessError) as error:
        detail = getattr(error, "stderr", None)
        logger.warning("compilation failed: %s %s", error, (detail or b"").decode()[-500:])
        return None


def _batch(library: ctypes.CDLL, name: str, function: casadi.Function) -> Batch:
    call = getattr(library, name)
    pointer = ctypes.POINTER(ctypes.c_double)
    call.argtypes = [pointer, pointer, ctypes.c_long]
    call.restype = None
    inputs, outputs = function.numel_in(0), function.numel_out(0)

    def evaluate(x: Float[ndarray, "inputs samples"]) -> Float[ndarray, "outputs samples"]:
        rows, samples = x.shape
        if rows != inputs:
            raise ValueError(f"{rows} rows of input, expected {inputs}")
        padded = -(-samples // LANES) * LANES
        full = np.zeros((inputs, padded))
        full[:, :samples] = x
        # The last state again and again, so that the lanes that are thrown away stay finite.
        full[:, samples:] = x[:, -1:]
        result = np.empty((outputs, padded))
        call(full.ctypes.data_as(pointer), result.ctypes.data_as(pointer), padded)
        return result[:, :samples]

    return evaluate
