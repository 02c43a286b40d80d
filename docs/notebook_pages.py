"""The notebooks as pages: executed while the site is built, with all that their cells show."""

from __future__ import annotations

import base64
import os
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import jupytext
from nbclient import NotebookClient
from traitlets.config import Config

# The kernel's debugger would say on every page that it cannot follow frozen modules.
QUIET = {"PYDEVD_DISABLE_FILE_VALIDATION": "1"}
LONGEST = 600  # [s] that a cell may take
OFFER = "[This page as a notebook]({name}) (open it with Jupytext)."
PLACE = '<div class="shown" id="{mark}"></div>'


@dataclass
class NotebookPage:
    """A notebook that was run.

    Attributes:
        markdown: Its cells and what they show; of HTML only the places.
        pictures: Content by file name, which the text names.
        html: By mark of its place, what goes there when the text has become HTML: a picture in three
            dimensions holds its viewer, and no reader of Markdown need pass through that.
    """

    markdown: str = ""
    pictures: dict[str, bytes] = field(default_factory=dict)
    html: dict[str, str] = field(default_factory=dict)

    def placed(self, page: str) -> str:
        """The page in HTML with its places filled."""
        for mark, content in self.html.items():
            place = PLACE.format(mark=mark)
            if place not in page:
                raise ValueError(f"no place for {mark} on the page of the notebook")
            page = page.replace(place, content)
        return page


def run_notebook(notebook: Path, folder: Path) -> NotebookPage:
    """Execute a notebook in a folder, and lay it out as a page.

    Raises:
        nbclient.exceptions.CellExecutionError: If a cell fails.
        ValueError: If a cell warns, or shows what a page cannot.
    """
    read = jupytext.read(notebook, fmt="py:percent")
    with TemporaryDirectory(prefix="oed-kernel-") as sockets:  # no port that others could listen at
        at = {"transport": "ipc", "ip": f"{sockets}/kernel"}
        NotebookClient(
            read,
            timeout=LONGEST,
            kernel_name="python3",
            config=Config({"ConnectionFileMixin": at}),
            resources={"metadata": {"path": str(folder)}},
        ).execute(env={**os.environ, **QUIET})
    page = NotebookPage()
    parts: list[str] = []
    for cell in read.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```python\n{cell.source}\n```")
        parts += [_shown(output, notebook.stem, page) for output in cell.outputs]
    page.markdown = "\n\n".join([*parts, OFFER.format(name=notebook.name)])
    return page


def _shown(output: Any, stem: str, page: NotebookPage) -> str:
    """What a cell shows, as Markdown; pictures and HTML are kept beside it."""
    if output.output_type == "stream":
        if output.name != "stdout":
            raise ValueError(f"{stem}: a cell warns: {output.text}")
        return _text(output.text)
    data = output.get("data", {})
    if "text/html" in data:
        mark = f"{stem}-shown-{len(page.html) + 1}"
        page.html[mark] = data["text/html"]
        return PLACE.format(mark=mark)
    if "image/png" in data:
        name = f"{stem}-{len(page.pictures) + 1}.png"
        page.pictures[name] = base64.b64decode(data["image/png"])
        return f"![What the code above draws]({name})"
    if "text/plain" in data:
        return _text(data["text/plain"])
    raise ValueError(f"{stem}: a page cannot show {output.output_type} of {', '.join(data)}")


def _text(words: str) -> str:
    return f"```{{ .text .shown .no-copy }}\n{words.rstrip()}\n```"
