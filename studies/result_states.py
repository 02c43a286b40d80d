"""Which results were made by the code as it is: results/README.md.

    python -m studies.result_states

Each claim of the readme names a command and a folder of `results/`. What that command runs, with all
of this project that it imports, is held against the same modules at the commit that made the
folder. A test holds the page against the results, and fails where a result is said to be of the
present code and is not.
"""

from __future__ import annotations

import io
import re
import subprocess
import tarfile
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from oed.commands.options import parse
from oed.errors import OedError
from oed.process_end import leave
from oed.report.code_digest import PACKAGES, code_of, digest_of
from oed.report.json_file import read_json, write_atomically
from oed.report.table import Row, markdown_table
from studies.data_folders import REPOSITORY

COMMAND = re.compile(r"`(?:python -m (studies\.\w+)|(make paper))[^`]*`")
FOLDER = re.compile(r"`results/(\w+)/")
RECORDS = ("provenance.json", "diagnosis.json")  # that say which commit made a folder
PAPER = "studies.paper"  # of `make paper`
PAGE = REPOSITORY / "results" / "README.md"
DIGITS = 8
UNCHANGED, UNKNOWN = "none", "not known: the history does not have that commit"
TEXT = """# Which code made these results

Each folder holds what its command left. *Changed since* names the packages behind the command in which some statement is another now
than at the commit that made the results; comments and layout do not count. Where it says {unchanged}, the code as it is made them. A change
may move a number or none: the command tells. Written by `python -m studies.result_states`.

{table}
"""


@dataclass(frozen=True)
class Options:
    """Which results were made by the code as it is?"""


@dataclass(frozen=True)
class Made:
    """A folder of results and the code that made it.

    Attributes:
        folder: Of `results/`.
        module: That made it.
        commit: Of the code.
        dirty: Whether the checkout differed from that commit.
        digest: Of the code behind the module at that commit; empty where that is not known.
        changed: Packages in which that code is another now.
    """

    folder: str
    module: str
    commit: str
    dirty: bool
    digest: str
    changed: tuple[str, ...]


def claims(readme: str) -> dict[str, str]:
    """Folder of `results/` -> module, as the readme's table of claims has them."""
    found = {}
    for line in readme.splitlines():
        command, folder = COMMAND.search(line), FOLDER.search(line)
        if line.startswith("|") and command and folder:
            found[folder[1]] = command[1] or PAPER
    return found


def origin(folder: Path) -> tuple[str, bool]:
    """Commit that made a folder of results, and whether the checkout differed from it.

    Raises:
        OedError: If no record in it says so.
    """
    for name in RECORDS:
        if (folder / name).is_file():
            record = read_json(folder / name)
            if record.get("commit"):
                return str(record["commit"]), bool(record.get("dirty", False))
    raise OedError(f"{folder}: none of {', '.join(RECORDS)} says which commit made it; run it anew")


def states(repository: Path) -> list[Made]:
    """Of every folder that the readme claims something by, what made it and what changed since."""
    result = []
    readme = (repository / "README.md").read_text(encoding="utf-8")
    for folder, module in sorted(claims(readme).items()):
        commit, dirty = origin(repository / "results" / folder)
        with tempfile.TemporaryDirectory() as root:
            if not extract(repository, commit, Path(root), *PACKAGES):
                result.append(Made(folder, module, commit, dirty, "", (UNKNOWN,)))
                continue
            then = code_of(Path(root), *run_by(Path(root), module))
        now = code_of(repository, *run_by(repository, module))
        other = {m for m in then.keys() | now.keys() if then.get(m) != now.get(m)}
        result.append(Made(folder, module, commit, dirty, digest_of(then), _packages(other)))
    return result


def page(made: Iterable[Made]) -> str:
    """The page, as Markdown."""
    rows: list[Row] = [
        {
            "results": f"`{m.folder}`",
            "made by": f"`{m.module}`",
            "commit": m.commit[:DIGITS] + (" and changes beside it" if m.dirty else ""),
            "its code": m.digest[:DIGITS],
            "changed since": ", ".join(m.changed) or UNCHANGED,
        }
        for m in made
    ]
    return TEXT.format(table=markdown_table(rows), unchanged=UNCHANGED)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page."""
    parse(Options, prog="python -m studies.result_states", arguments=arguments)
    write_atomically(PAGE, page(states(REPOSITORY)))
    print(f"wrote {PAGE.relative_to(REPOSITORY)}")
    return 0


def extract(repository: Path, commit: str, root: Path, *folders: str) -> bool:
    """Lay folders out as they were at a commit, those that it has; say whether git has the commit.

    Args:
        repository: A checkout.
        commit: By its hash or name.
        root: Where to; that is there.
        folders: Of the checkout.
    """
    git = ["git", "-C", str(repository)]
    listed = subprocess.run(  # noqa: S603 - fixed program
        [*git, "ls-tree", "--name-only", commit], capture_output=True, text=True, check=False
    )
    if listed.returncode != 0:
        return False
    there = [name for name in listed.stdout.split() if name in folders]
    packed = subprocess.run(  # noqa: S603 - likewise
        [*git, "archive", commit, *there], capture_output=True, check=True
    )
    with tarfile.open(fileobj=io.BytesIO(packed.stdout)) as archive:
        archive.extractall(root, filter="data")
    return True


def run_by(root: Path, module: str) -> tuple[str, ...]:
    """What `python -m` of a module runs: of a package, its `__main__` too."""
    folder = root.joinpath(*module.split("."))
    return (module, f"{module}.__main__") if folder.is_dir() else (module,)


def _packages(modules: Iterable[str]) -> tuple[str, ...]:
    """The packages that modules lie in: `oed.design`; modules beside them are of `oed` itself."""
    parts = (module.split(".") for module in modules)
    return tuple(sorted({".".join(p[:2] if len(p) > 2 else p[:1]) for p in parts}))


if __name__ == "__main__":
    leave(main, "studies.result_states")
