"""What an installer gets: requirements that hold, a wheel that is whole and works elsewhere."""

import ast
import json
import re
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import numpy as np
import pytest
from packaging.requirements import Requirement
from packaging.version import Version

from oed import __version__
from tests.docs.code_blocks import blocks
from tests.experiment.tiny_dataset import tiny_files, write_files
from tests.paths import REPO

PROJECT = tomllib.loads((REPO / "pyproject.toml").read_text())["project"]
# Where a package that is imported has another name in the registry.
REGISTRY_NAMES = {
    "pydrake": "drake",
    "pinocchio": "pin",
    "coal": "pin",  # which requires it, at the version that it was built with
    "yaml": "pyyaml",
    "tomli_w": "tomli-w",
    "lazy_loader": "lazy-loader",
    "cycler": "matplotlib",  # which it is a part of
}


def pins() -> dict[str, Version]:
    lines = (REPO / "environment.txt").read_text().splitlines()
    found = [re.match(r"([a-z0-9.-]+)==(\S+)", line) for line in lines]
    return {match[1]: Version(match[2]) for match in found if match}


def required(*extras: str) -> dict[str, Requirement]:
    texts = [*PROJECT["dependencies"]]
    for extra in extras:
        texts += PROJECT["optional-dependencies"][extra]
    found = [Requirement(text) for text in texts]
    return {requirement.name: requirement for requirement in found if requirement.name != "oed"}


def test_the_lock_satisfies_every_requirement():
    locked = pins()
    for name, requirement in required("ros", "mujoco", "docs", "dev").items():
        assert name in locked, f"environment.txt lacks {name}"
        assert requirement.specifier.contains(locked[name]), f"{name} {locked[name]}"


def test_every_lower_bound_is_the_series_that_the_tests_run_with():
    locked = pins()
    for name, requirement in required("ros", "mujoco", "docs", "dev").items():
        (bound,) = requirement.specifier
        assert bound.operator == ">="
        series = bound.version.split(".")[:2]
        assert series == str(locked[name]).split(".")[: len(series)], name


def imported_packages() -> set[str]:
    """Packages from outside that some file of oed imports or takes files of, wherever in it."""
    found = set()
    for file in (REPO / "oed").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                found.add(node.module.partition(".")[0])
            elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("files"):
                found |= {a.value for a in node.args if isinstance(a, ast.Constant)}
    return found - set(sys.stdlib_module_names) - {"oed"}


def test_every_package_that_is_imported_is_required():
    names = {REGISTRY_NAMES.get(package, package) for package in imported_packages()}
    assert names <= set(required("ros", "mujoco")), names - set(required("ros", "mujoco"))


def test_the_version_is_stated_once():
    assert PROJECT["dynamic"] == ["version"]
    assert f"version: {__version__}\n" in (REPO / "CITATION.cff").read_text()


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """Built without isolation, from what the environment holds: nothing is fetched."""
    out = tmp_path_factory.mktemp("dist")
    source = tmp_path_factory.mktemp("source")
    files = subprocess.run(
        ["git", "ls-files", "oed", "pyproject.toml", "README.md", "LICENSE"],
        cwd=REPO,
        capture_output=True,
        text=True,
        check=True,
    )
    for name in files.stdout.splitlines():
        target = source / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes((REPO / name).read_bytes())
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(out)]
    subprocess.run([*command, str(source)], check=True, capture_output=True)
    (found,) = out.glob("*.whl")
    return found


def test_the_wheel_holds_every_file_of_the_library(wheel):
    files = {str(p.relative_to(REPO)) for p in (REPO / "oed").rglob("*") if p.is_file()}
    names = set(zipfile.ZipFile(wheel).namelist())
    missing = {name for name in files - names if "__pycache__" not in name}
    assert not missing
    assert "oed/py.typed" in names


USE = """
import sys
from pathlib import Path
import oed
assert Path(oed.__file__).is_relative_to(sys.prefix), oed.__file__
from importlib.metadata import version
assert version("oed") == oed.__version__
from oed.dynamics.models import build_model
from oed.experiment.read_dataset import read_dataset
from oed.report.page import render_page
dataset = read_dataset(sys.argv[1])
print(len(dataset.recordings), len(build_model("standard", dataset.robot).effects))
"""


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory) -> Path:
    """The Python of an environment that holds the wheel; what it requires is lent by the tests'."""
    home = tmp_path_factory.mktemp("installed") / "env"
    venv.create(home, with_pip=False)
    packages = next(home.glob("lib/python*/site-packages"))
    lent = sysconfig.get_path("purelib")
    (packages / "lent.pth").write_text(f"import site; site.addsitedir({lent!r})\n")
    install(wheel, packages)
    return home / "bin" / "python"


def install(source: Path, packages: Path) -> None:
    target = ["--no-deps", "--no-index", "--no-compile", "--quiet", "--no-build-isolation"]
    pip = [sys.executable, "-m", "pip", "install", *target, "--target", str(packages), str(source)]
    subprocess.run(pip, check=True, capture_output=True)


def run(python: Path, folder: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    """A Python process outside the checkout, with no word of the checkout in its environment."""
    command = [str(python), *map(str, arguments)]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_the_wheel_works_in_an_environment_of_its_own(installed, tmp_path):
    folder = write_files(tmp_path / "set", tiny_files())
    used = run(installed, tmp_path, "-c", USE, folder)
    assert used.returncode == 0, used.stderr
    assert used.stdout.split()[0] == "2"
    identify = ["-m", "oed", "identify", folder, "--out", "estimate"]
    told = run(installed, tmp_path, *identify)
    assert told.returncode in (0, 2), told.stderr
    assert "Traceback" not in told.stderr


# The modules of the how-to pages, as the entry points that these pages show name them.
HOW_TO = {"log-reader": "read_arm", "optimiser": "local_steps", "trajectory": "slow_sines"}


def test_an_installed_package_adds_reader_optimiser_and_trajectories(installed, tmp_path):
    """What the how-to pages show, as a package that pip installs: plain commands know it."""
    source = tmp_path / "source"
    (source / "my_package").mkdir(parents=True)
    points = []
    for page, module in HOW_TO.items():
        text = REPO / "docs" / "how-to" / f"{page}.md"
        code = [block for block in blocks(text, "python") if "oed.commands.main" not in block]
        (source / "my_package" / f"{module}.py").write_text("\n".join(code))
        points += blocks(text, "toml")
    about = '[project]\nname = "my-package"\nversion = "1"\n'
    (source / "pyproject.toml").write_text("\n".join([about, *points]))
    install(source, next(installed.parents[1].glob("lib/python*/site-packages")))
    t = np.arange(0.0, 20.0, 0.02)
    q = np.stack([0.5 * np.sin(1.3 * t) + 0.2 * np.sin(3 * t), 0.6 * np.sin(1.7 * t)], axis=1)
    rows = np.column_stack([t, q, q * 3.0 + np.sin(5 * t)[:, None]])
    rows.astype("<f8").tofile(tmp_path / "log.arm")
    scara = ["--robot", "builtin:imi_scara", "--out"]
    read = run(installed, tmp_path, "-m", "oed", "import", "log.arm", *scara, "mydata")
    assert read.returncode == 0, read.stderr
    wishes = ["--optimiser", "local_steps", "--trajectory", "slow_sines"]
    design = ["-m", "oed", "design", *scara, "design", *wishes, "--no-clearance", "--smoke"]
    told = run(installed, tmp_path, *design)
    assert told.returncode == 0, told.stderr
    record = json.loads((tmp_path / "design" / "design.json").read_text())
    assert record["optimiser"] == "local_steps"
    assert np.shape(record["coefficients"]["frequency"]) == (2, 2)


def test_the_oldest_python_that_is_named_is_the_least_and_the_tests_run_with_it():
    named = {c.rpartition(" ")[2] for c in PROJECT["classifiers"] if "Python :: 3." in c}
    oldest = min(named, key=Version)
    assert PROJECT["requires-python"] == f">={oldest}"
    assert sys.version.startswith(f"{oldest}.")


def test_what_is_said_names_no_page_of_the_checkout():
    named = []
    for path in (REPO / "oed").rglob("*.py"):
        nodes = list(ast.walk(ast.parse(path.read_text())))
        docstrings = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        said = (n for n in nodes if isinstance(n, ast.Constant) and id(n) not in docstrings)
        named += [(path.name, n.value) for n in said if re.search(r"docs/\S+\.md", str(n.value))]
    assert not named
