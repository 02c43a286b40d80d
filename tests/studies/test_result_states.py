"""The page of results says which code made them, and nothing is said to be of this code that is not."""

import json
import re
import subprocess

import pytest

from oed.report.code_digest import code_of, digest_of
from studies import result_states
from studies.data_folders import REPOSITORY
from studies.result_states import (
    DIGITS,
    PAGE,
    UNCHANGED,
    UNKNOWN,
    claims,
    extract,
    origin,
    run_by,
    states,
)

CELL = re.compile(r"\s*\|\s*")
README = """
| claim | command | result |
|---|---|---|
| one | `python -m studies.one --seeds 3` | `results/one/summary.md` |
| two | `make paper` | `results/two/report.html`, `results/two/proof.png` |
"""


def committed():
    lines = [x for x in PAGE.read_text(encoding="utf-8").splitlines() if x.startswith("| `")]
    return [[cell.strip("`") for cell in CELL.split(line)[1:-1]] for line in lines]


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """The results as they are committed: a rerun that nobody has committed is not what the page is of."""
    root = tmp_path_factory.mktemp("kept")
    if not extract(REPOSITORY, "HEAD", root, "results"):
        return REPOSITORY / "results"
    return root / "results"


def test_every_folder_of_results_has_a_line_with_the_commit_that_made_it(kept) -> None:
    folders = {p.name for p in kept.iterdir() if p.is_dir()}
    assert {line[0] for line in committed()} == folders
    for folder, _, commit, *_ in committed():
        made, dirty = origin(kept / folder)
        assert commit == made[:DIGITS] + (" and changes beside it" if dirty else ""), (
            f"results/{folder} was made anew: run python -m studies.result_states"
        )


def test_what_is_said_to_be_of_this_code_is() -> None:
    for folder, module, _, digest, changed in committed():
        if changed == UNCHANGED:
            now = digest_of(code_of(REPOSITORY, *run_by(REPOSITORY, module)))
            assert now[:DIGITS] == digest, (
                f"the code behind results/{folder} has changed: run python -m studies.result_states"
            )


def test_claims_are_those_of_the_readme() -> None:
    assert claims(README) == {"one": "studies.one", "two": result_states.PAPER}


@pytest.fixture
def repository(tmp_path):
    """Two results, made one commit after another."""

    def git(*words):
        run = ["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b", *words]
        return subprocess.run(run, check=True, capture_output=True, text=True).stdout.strip()

    def write(name, text):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)

    def made(folder):
        git("add", "-A")
        git("commit", "-qm", "code")
        write(f"results/{folder}/provenance.json", json.dumps({"commit": git("rev-parse", "HEAD")}))

    git("init", "-q")
    write("README.md", README)
    for name in ("studies/__init__.py", "oed/__init__.py", "oed/deep/__init__.py"):
        write(name, "")
    write("studies/one.py", "from oed.deep import inner\n")
    write("studies/paper.py", "import studies.one\n")
    write("oed/deep/inner.py", "x = 1\n")
    made("one")
    write("oed/deep/inner.py", "x = 2\n")
    made("two")
    return tmp_path


def test_what_changed_since_is_named(repository) -> None:
    one, two = states(repository)
    assert (one.folder, one.changed) == ("one", ("oed.deep",))
    assert (two.folder, two.changed) == ("two", ())
    assert two.digest != one.digest


def test_a_commit_that_is_gone_is_said_to_be_unknown(repository) -> None:
    (repository / "results/one/provenance.json").write_text(json.dumps({"commit": "0" * 40}))
    assert states(repository)[0].changed == (UNKNOWN,)
