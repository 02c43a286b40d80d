"""A predictor as C99 that needs nothing but the mathematics library."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable
from pathlib import Path

import casadi

from oed.export.predictor import Predictor
from oed.in_comment import in_comment
from oed.report.json_file import write_atomically

FUNCTIONS = {
    "torque": "torque as recordings show it, and what is kept for the next instant",
    "torque_begin": "what is kept at the first instant",
    "arm": "torque that the arm needs, without delays and gains of the measurement",
    "arm_begin": "what is kept at the first instant",
    "gravity": "weight of all bodies",
    "position": "springs, ripples, offsets: what depends on position alone",
    "friction": "what brakes, and what effects of friction are added to it",
    "inertia": "acceleration, Coriolis and centrifugal torque, rotors among them",
}


def write_c(predictor: Predictor, out: Path, name: str = "oed_model") -> tuple[Path, Path]:
    """Write NAME.c and NAME.h.

    Args:
        predictor: To write.
        out: Folder that is there.
        name: Of the files, and before every name in them.

    Returns:
        Source and header.
    """
    source, header = out / f"{name}.c", out / f"{name}.h"
    generated = generated_code(predictor.functions.values())
    write_atomically(source, generated + _wrappers(predictor, name))
    write_atomically(header, _header(predictor, name))
    return source, header


def generated_code(functions: Iterable[casadi.Function]) -> str:
    """CasADi's own code of functions, which the file that has it knows alone."""
    with tempfile.TemporaryDirectory() as folder:
        options = {"with_export": False, "casadi_int": "int", "unroll_args": False}
        generator = casadi.CodeGenerator("generated.c", options)
        for each in functions:
            generator.add(each)
        generator.generate(f"{folder}/")
        text = (Path(folder) / "generated.c").read_text(encoding="utf-8")
    return re.sub(r"^int (?=\w+\(const casadi_real\*\* arg)", "static int ", text, flags=re.M)


def _signature(predictor: Predictor, name: str, function: str) -> str:
    n, kept = predictor.n, len(predictor.recorded.keeps)
    own = kept if function.startswith("torque") else len(predictor.arm.keeps)
    state = f"const double q[{n}], const double dq[{n}], const double ddq[{n}]"
    memory = f"const double memory[{max(own, 1)}]"
    if function.endswith("_begin"):
        return f"void {name}_{function}({state}, double memory[{max(own, 1)}])"
    if function in ("torque", "arm"):
        following = f"double tau[{n}], double next[{max(own, 1)}]"
        return f"void {name}_{function}({state}, {memory}, {following})"
    return f"void {name}_{function}({state}, {memory}, double tau[{n}])"


def _wrappers(predictor: Predictor, name: str) -> str:
    lines = ["", f'#include "{name}.h"', ""]
    for function, compiled in predictor.functions.items():
        begun, whole = function.endswith("_begin"), function in ("torque", "arm")
        given = "q, dq, ddq" if begun else "q, dq, ddq, memory"
        filled = "memory" if begun else "tau, next" if whole else "tau"
        arg, res, iw, w = (
            max(compiled.sz_arg(), 1),
            compiled.sz_res(),
            compiled.sz_iw(),
            compiled.sz_w(),
        )
        lines += [
            f"{_signature(predictor, name, function)} {{",
            f"  const casadi_real *arg[{arg}] = {{{given}}};",
            f"  casadi_real *res[{max(res, 1)}] = {{{filled}}};",
            f"  casadi_int iw[{max(iw, 1)}];",
            f"  casadi_real w[{max(w, 1)}];",
            f"  {function}(arg, res, iw, w, 0);",
            "}",
            "",
        ]
    return "\n".join(lines)


def _header(predictor: Predictor, name: str) -> str:
    guard = f"{name.upper()}_H"
    left_out = [
        f"   Left out: {in_comment(o.name)}: {in_comment(o.reason)}." for o in predictor.left_out
    ]
    kept = {"torque": predictor.recorded.keeps, "arm": predictor.arm.keeps}
    lines = [
        f"/* Torque model of {in_comment(predictor.model.robot.name)}, written by oed. C99, needs -lm alone.",
        f"   Joints: {in_comment(', '.join(predictor.model.robot.joint_names))}. SI units.",
        f"   One call every {predictor.step!r} s. Memory comes from {name}_torque_begin, then from what",
        "   the last call left in next, which must be another array than memory.",
        *left_out,
        "*/",
        f"#ifndef {guard}",
        f"#define {guard}",
        "#ifdef __cplusplus",
        'extern "C" {',
        "#endif",
        f"#define {name.upper()}_JOINTS {predictor.n}",
        f"#define {name.upper()}_STEP {predictor.step!r}",
    ]
    for which, names in kept.items():
        lines.append(f"#define {name.upper()}_{which.upper()}_MEMORY {len(names)}")
        lines += [f"/*   {k}: {in_comment(each)} */" for k, each in enumerate(names[:MOST_NAMES])]
    for function in predictor.functions:
        lines += [f"/* {FUNCTIONS[function]} */", f"{_signature(predictor, name, function)};"]
    return "\n".join([*lines, "#ifdef __cplusplus", "}", "#endif", "#endif", ""])


MOST_NAMES = 100  # of what is kept, which the header lists
