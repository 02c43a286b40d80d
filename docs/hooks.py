"""What the documentation takes from the code, and its formulas, at build time."""

from __future__ import annotations

import re
from html import unescape
from typing import Any

from latex2mathml.converter import convert

from oed.dynamics.effects.catalogue import CATALOGUE, CatalogueEntry

EFFECTS = "reference/effects.md"
FORMULA = re.compile(
    r'<(?P<tag>span|div) class="arithmatex">\\[(\[](?P<tex>.*?)\\[)\]]</(?P=tag)>', re.DOTALL
)


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> str:
    """Append the catalogue to its page."""
    if page.file.src_uri != EFFECTS:
        return markdown
    return "\n\n".join([markdown, *map(effect_page, CATALOGUE.values())])


def on_page_content(html: str, **_: Any) -> str:
    """Turn formulas into MathML, which browsers draw without a script."""
    return FORMULA.sub(_mathml, html)


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
