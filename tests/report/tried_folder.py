"""A run that leaves files of given content in a folder for results."""

from pathlib import Path

from oed.report.result_folder import ResultFiles

FILES = ResultFiles("try", ("a.txt", "b.txt", "more/c.txt"))


def run(out: Path, **texts: str) -> None:
    with FILES.in_folder(out) as results, results.replaced() as new:
        fill(new, **texts)


def fill(folder: Path, **texts: str) -> None:
    for name, text in texts.items():
        path = folder / f"{name.replace('_', '/')}.txt"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)


def listing(folder: Path) -> dict[str, str]:
    """Content of all files that a user put there or reads."""
    files = (path for path in folder.rglob("*") if path.is_file())
    told = {path.relative_to(folder).as_posix(): path.read_text() for path in files}
    return {name: text for name, text in told.items() if not name.startswith(".oed/")}
