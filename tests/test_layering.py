"""The order of the packages holds: data flow one way, and so do the imports."""

import ast
from pathlib import Path

import pytest

from tests.paths import REPO

ORDER = (
    "robot",
    "dynamics",
    "design",
    "experiment",
    "estimation",
    "checkup",
    "diagnosis",
    "report",
    "export",
    "commands",
)
SHARED_BY_ALL = (
    "counted",
    "in_comment",
    "largest_number",
    "errors",
    "input_file",
    "one_thread",
    "parallel_map",
    "process_end",
    "progress",
    "registered",
)
# Within the diagnosis the same holds: folders and files, each of which may import those before it.
DIAGNOSIS_ORDER = (
    "numbers",
    "candidates",
    "rows",
    "problem",
    "evidence",
    "selection",
    "inference",
    "setup",
    "diagnose",
    "discrimination",
)
OUTSIDE = ("studies", "tests", "paper_figures")
# A figure reads results/: what it shows was computed, and recorded, by a study.
NOT_IN_FIGURES = ("oed.design", "scipy.optimize", "cma", "casadi", "cvxpy", "clarabel", "scs")


def imported_modules(file: Path, root: Path) -> list[tuple[int, str]]:
    """Every module that a file imports, wherever in it, as (line, absolute dotted name)."""
    package = file.relative_to(root).parent.parts
    found: list[tuple[int, str]] = []
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"), str(file))):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = ".".join((*base, *(node.module or "").split("."))).strip(".")
            # `from oed import design` names a package in the alias, not in the module.
            found += [(node.lineno, f"{module}.{alias.name}") for alias in node.names]
    return found


def is_within(module: str, package: str) -> bool:
    return module == package or module.startswith(package + ".")


def faults_of_library_file(file: Path, root: Path) -> list[str]:
    parts = file.relative_to(root).with_suffix("").parts
    layer = parts[1]
    if layer in ORDER:
        allowed = (*SHARED_BY_ALL, *ORDER[: ORDER.index(layer) + 1])
    elif layer == "__main__":
        allowed = (*SHARED_BY_ALL, *ORDER)
    elif layer in SHARED_BY_ALL or layer == "__init__":
        allowed = SHARED_BY_ALL
    else:
        return [f"{file.relative_to(root)}: {layer!r} has no place in the order {ORDER}"]
    faults = []
    for line, module in imported_modules(file, root):
        top, *inner = module.split(".")
        upstream = top == "oed" and inner and inner[0] in ORDER and inner[0] not in allowed
        if upstream or top in OUTSIDE:
            faults.append(f"{file.relative_to(root)}:{line} imports {module}")
    return faults


def faults_within_diagnosis(file: Path, root: Path) -> list[str]:
    part = file.relative_to(root).with_suffix("").parts[2]
    if part == "__init__":
        return []
    if part not in DIAGNOSIS_ORDER:
        return [f"{file.relative_to(root)}: {part!r} has no place in {DIAGNOSIS_ORDER}"]
    later = DIAGNOSIS_ORDER[DIAGNOSIS_ORDER.index(part) + 1 :]
    return [
        f"{file.relative_to(root)}:{line} imports {module}"
        for line, module in imported_modules(file, root)
        if any(is_within(module, f"oed.diagnosis.{name}") for name in later)
    ]


def faults_of_figure(file: Path, root: Path) -> list[str]:
    return [
        f"{file.relative_to(root)}:{line} imports {module}"
        for line, module in imported_modules(file, root)
        if any(is_within(module, forbidden) for forbidden in NOT_IN_FIGURES)
    ]


def module_of(file: Path, root: Path) -> str:
    parts = file.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def circles(root: Path) -> list[str]:
    """Files of one program that import one another, at whatever place in the file."""
    files = {
        module_of(file, root): file
        for top in ("oed", *OUTSIDE)
        for file in sorted((root / top).rglob("*.py"))
    }
    imports: dict[str, set[str]] = {}
    for name, file in files.items():
        imports[name] = set()
        for _, module in imported_modules(file, root):
            # `from oed.robot import Robot` names a file or what stands in one.
            wanted = next((m for m in (module, module.rpartition(".")[0]) if m in files), name)
            imports[name] |= {wanted} - {name}
    # What imports nothing that is left is in no circle, nor what nothing left imports.
    left = set(files)
    while True:
        imported = {module for name in left for module in imports[name] & left}
        inner = {name for name in left & imported if imports[name] & left}
        if inner == left:
            break
        left = inner
    return [f"{name} imports {', '.join(sorted(imports[name] & left))}" for name in sorted(left)]


def layering_faults(root: Path) -> list[str]:
    faults = []
    for file in sorted((root / "oed").rglob("*.py")):
        faults += faults_of_library_file(file, root)
    for file in sorted((root / "oed" / "diagnosis").rglob("*.py")):
        faults += faults_within_diagnosis(file, root)
    for file in sorted((root / "paper_figures").rglob("*.py")):
        faults += faults_of_figure(file, root)
    return faults


def test_imports_run_downstream_only() -> None:
    assert layering_faults(REPO) == []


def test_no_file_imports_one_that_imports_it() -> None:
    assert circles(REPO) == []


@pytest.mark.parametrize(
    "back",
    [
        "from oed.robot.a import f",
        "from oed.robot import a",
        "from .a import f",
        "if TYPE_CHECKING:\n    from oed.robot.a import F",
        "def g():\n    import oed.robot.a",
    ],
)
def test_a_circle_of_files_is_caught(tmp_path: Path, back: str) -> None:
    folder = tmp_path / "oed" / "robot"
    folder.mkdir(parents=True)
    for name, text in (
        ("before", "from oed.robot.a import f"),
        ("a", "from oed.robot.b import g"),
        ("b", "from oed.robot.c import h"),
        ("c", back),
        ("after", "import numpy"),
    ):
        (folder / f"{name}.py").write_text(text + "\n", encoding="utf-8")
    caught = circles(tmp_path)
    assert [line.split()[0] for line in caught] == ["oed.robot.a", "oed.robot.b", "oed.robot.c"]
    (folder / "c.py").write_text("from oed.robot.after import x\n", encoding="utf-8")
    assert circles(tmp_path) == []


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("oed/robot/x.py", "from oed.dynamics import Motion"),
        ("oed/robot/x.py", "from oed import report"),
        ("oed/dynamics/effects/x.py", "from ...design.criteria import log_det"),
        ("oed/estimation/x.py", "import oed.diagnosis.residual as residual"),
        ("oed/diagnosis/evidence/x.py", "from oed.diagnosis.selection.search import search"),
        ("oed/diagnosis/inference/x.py", "from oed.diagnosis.diagnose import diagnose"),
        ("oed/report/x.py", "def f():\n    from studies.identify import run"),
        ("oed/errors.py", "from oed.robot import Robot"),
        ("oed/helpers/x.py", "import numpy"),
        ("paper_figures/x.py", "from oed.design import problem"),
        ("paper_figures/x.py", "from scipy.optimize import minimize"),
    ],
)
def test_a_planted_fault_is_caught(tmp_path: Path, path: str, line: str) -> None:
    file = tmp_path / path
    file.parent.mkdir(parents=True)
    file.write_text(line + "\n", encoding="utf-8")
    assert len(layering_faults(tmp_path)) == 1


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("oed/dynamics/x.py", "from oed.robot import Robot"),
        ("oed/dynamics/effects/x.py", "from ..motion import Motion"),
        ("oed/robot/x.py", "from oed.errors import RobotError"),
        ("oed/diagnosis/selection/x.py", "from oed.diagnosis.numbers import NAMED"),
        ("oed/diagnosis/discrimination/x.py", "from oed.diagnosis.diagnose import diagnose"),
        ("oed/report/x.py", "from oed.estimation import Estimate"),
        ("paper_figures/x.py", "from oed.report.style import save_figure"),
    ],
)
def test_a_downstream_import_passes(tmp_path: Path, path: str, line: str) -> None:
    file = tmp_path / path
    file.parent.mkdir(parents=True)
    file.write_text(line + "\n", encoding="utf-8")
    assert layering_faults(tmp_path) == []
