"""A hash of the code behind a result: of a module and all of this project that it imports."""

from __future__ import annotations

import ast
import hashlib
import platform
from collections.abc import Iterator
from functools import cache, lru_cache
from pathlib import Path

from oed.report.provenance import CHECKOUT, KEY_PACKAGES, package_versions

PACKAGES = ("oed", "studies", "paper_figures")  # of this project


@lru_cache
def code_digest(*modules: str) -> str:
    """Hash of what these modules do; comments, docstrings and layout do not count.

    Args:
        modules: Dotted names. What they import counts, wherever in a file that stands, with all
            that this imports; of other packages the versions of those that can move a number.
            A module that is none of this project's, such as a notebook, counts by its name.
    """
    digest = hashlib.sha256(repr((modules, platform.python_version())).encode())
    digest.update(repr(sorted(package_versions(KEY_PACKAGES).items())).encode())
    seen: set[str] = set()
    todo = list(modules)
    while todo:
        module = todo.pop()
        if module not in seen:
            seen.add(module)
            todo += _code(module)[1]
    for module in sorted(seen):
        digest.update(f"{module}\0{_code(module)[0]}\0".encode())
    return digest.hexdigest()


@cache
def _code(module: str) -> tuple[str, tuple[str, ...]]:
    """Hash of a module's file, and what it imports; empty where the project has no such file."""
    file = _file(module)
    if file is None:
        return "", ()
    tree = ast.parse(file.read_bytes())
    imports = tuple(_imports(tree, module, is_package=file.stem == "__init__"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and _is_text(body[0]):
            node.body = body[1:]  # pyright: ignore[reportAttributeAccessIssue]  # has a body
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), imports


def _file(module: str) -> Path | None:
    if module.partition(".")[0] not in PACKAGES:
        return None
    place = CHECKOUT.joinpath(*module.split("."))
    choices = (place.with_name(f"{place.name}.py"), place / "__init__.py")
    return next((file for file in choices if file.is_file()), None)


def _imports(tree: ast.Module, module: str, *, is_package: bool) -> Iterator[str]:
    """Every module that is imported, and each package above it; also names that are no module."""
    parts = module.split(".")
    names = [".".join(parts[:i]) for i in range(1, len(parts))]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = parts[: len(parts) - node.level + is_package] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            names += [base, *(f"{base}.{alias.name}" for alias in node.names)]
    for name in names:
        if _file(name) is not None:
            yield name


def _is_text(node: ast.stmt) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )
