"""What the documentation takes from the code, and its formulas, at build time."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from html import unescape
from pathlib import Path
from typing import Any

from command_pages import command_reference
from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from notebook_pages import NotebookPage, run_notebook

from oed.dynamics.effects.catalogue import CATALOGUE, CatalogueEntry
from oed.report.records.files import RECORDS, schema_name, schemas

REPO = Path(__file__).resolve().parent.parent
PROOF = "images/proof.png"
SCHEMAS = "reference/schemas"
CALLED = {"close_loop": "diagnose"}  # commands whose results have an older name
NOTEBOOKS: dict[str, NotebookPage] = {}  # by their pages, of the build that goes on
FORMULA = re.compile(
    r'<(?P<tag>span|div) class="arithmatex">\\[(\[](?P<tex>.*?)\\[)\]]</(?P=tag)>', re.DOTALL
)


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Run every notebook and make a page of it; add schemas and the proof."""
    for notebook in sorted(Path(config.docs_dir, "tutorials").glob("*.py")):
        page = f"tutorials/{notebook.stem}.md"
        NOTEBOOKS[page] = found = run_notebook(notebook, REPO)
        files.append(File.generated(config, page, content=found.markdown))
        for name, content in found.pictures.items():
            files.append(File.generated(config, f"tutorials/{name}", content=content))
    for name, schema in schemas().items():
        page = f"{SCHEMAS}/{name}"
        files.append(File.generated(config, page, content=json.dumps(schema, indent=2)))
    # The figure that the tutorials and the start page show is the committed result.
    files.append(
        File.generated(config, PROOF, abs_src_path=str(REPO / "results/loop_scara/proof.png"))
    )
    return files


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> str:
    """Append to a page what is made from the code."""
    made = GENERATED.get(page.file.src_uri)
    return markdown if made is None else f"{markdown}\n\n{made()}"


def on_page_content(html: str, *, page: Any, **_: Any) -> str:
    """Turn formulas into MathML, which browsers draw without a script; show what notebooks do."""
    notebook = NOTEBOOKS.get(page.file.src_uri, NotebookPage())
    return notebook.placed(FORMULA.sub(_mathml, html))


def _mathml(found: re.Match[str]) -> str:
    display = "block" if found["tag"] == "div" else "inline"
    return convert(unescape(found["tex"]), display=display)


def effect_page(entry: CatalogueEntry) -> str:
    """The page of one effect, as Markdown."""
    page = entry.page
    shapes = [
        f"| {shape.name} | {shape.unit} | {shape.lower:g} | {shape.upper:g} |"
        for shape in entry.shapes
    ]
    table = ["| shape | unit | least | largest |", "|---|---|---|---|", *shapes] if shapes else []
    confused = ", ".join(f"`{name}`" for name in page.confused_with) or "none"
    lines = [
        f"## `{entry.name}`",
        f"Torque: `{page.equation}`",
        f"**Parameters.** {page.parameters}",
        "\n".join(table),
        f"**What it leaves in a residual.** {page.signature}",
        f"**Confused with.** {confused}",
        f"**Exposed by.** {page.exposed_by}",
        f"**Source.** {page.source}",
    ]
    return "\n\n".join(line for line in lines if line)


def effect_pages() -> str:
    """All effects of the catalogue, as Markdown."""
    return "\n\n".join(map(effect_page, CATALOGUE.values()))


def schema_list() -> str:
    """Where the schema of each file is, as Markdown."""
    rows = [
        f"| `{name}` | `oed {CALLED.get(command, command)}` | [{schema_name(command, name)}](schemas/{schema_name(command, name)}) |"
        for command, files in RECORDS.items()
        for name in files
    ]
    return "\n".join(["| file | left by | schema |", "|---|---|---|", *rows])


def summary_of(study: str) -> Callable[[], str]:
    """The committed summary of a study, one heading lower than on its own, without its pictures."""

    def text() -> str:
        summary = (REPO / "results" / study / "summary.md").read_text(encoding="utf-8")
        lowered = re.sub(r"^#+ ", lambda found: f"#{found[0]}", summary, flags=re.MULTILINE)
        return re.sub(r"^!\[.*\n", "", lowered, flags=re.MULTILINE)

    return text


# By page: what is appended to it.
GENERATED: dict[str, Callable[[], str]] = {
    "reference/effects.md": effect_pages,
    "reference/commands.md": command_reference,
    "reference/public-arms.md": summary_of("public_arms"),
    "theory/estimators.md": summary_of("estimators"),
    "reference/files.md": schema_list,
}
