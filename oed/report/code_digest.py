"""A hash of the code behind a result: of a module and all of this project that it imports."""

from __future__ import annotations

import ast
import hashlib
import platform
import re
from collections.abc import Iterator
from functools import cache, lru_cache
from pathlib import Path
from typing import TypeGuard

from oed.report.provenance import CHECKOUT, KEY_PACKAGES, package_versions

STUDY = re.compile(r"studies(\.\w+)+")
PACKAGES = ("oed", "studies", "paper_figures")  # of this project


@lru_cache
def code_digest(*modules: str) -> str:
    """Hash of what these modules do, as `code_of`, and of the packages whose versions can move a number."""
    digest = hashlib.sha256(repr((modules, platform.python_version())).encode())
    digest.update(repr(sorted(package_versions(KEY_PACKAGES).items())).encode())
    digest.update(digest_of(code_of(CHECKOUT, *modules)).encode())
    return digest.hexdigest()


def digest_of(code: dict[str, str]) -> str:
    """One hash of the code of several modules."""
    return hashlib.sha256(repr(sorted(code.items())).encode()).hexdigest()


def code_of(root: Path, *modules: str) -> dict[str, str]:
    """Hash of what each of some modules does, and of all modules of this project that they import.

    Comments, docstrings and layout do not count.

    Args:
        root: Folder of the checkout.
        modules: Dotted names. What they import counts, wherever in a file that stands, with all
            that this imports. A module that is none of this project's, such as a notebook, has an
            empty hash.
    """
    result: dict[str, str] = {}
    todo = list(modules)
    while todo:
        module = todo.pop()
        if module not in result:
            result[module], imports = _code(root, module)
            todo += imports
    return result


def _code(root: Path, module: str) -> tuple[str, tuple[str, ...]]:
    """Hash of a module's file, and what it imports; empty where the project has no such file."""
    file = _file(root, module)
    if file is None:
        return "", ()
    digest, names = _parsed(file.read_bytes(), module, is_package=file.stem == "__init__")
    return digest, tuple(name for name in names if _file(root, name) is not None)


def _file(root: Path, module: str) -> Path | None:
    if module.partition(".")[0] not in PACKAGES:
        return None
    place = root.joinpath(*module.split("."))
    choices = (place.with_name(f"{place.name}.py"), place / "__init__.py")
    return next((file for file in choices if file.is_file()), None)


@cache
def _parsed(text: bytes, module: str, *, is_package: bool) -> tuple[str, tuple[str, ...]]:
    """Hash of a file's statements, and all that it may import."""
    tree = ast.parse(text)
    names = tuple(_imports(tree, module, is_package=is_package))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and _is_text(body[0]):
            node.body = body[1:]  # pyright: ignore[reportAttributeAccessIssue]  # has a body
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), names


def _imports(tree: ast.Module, module: str, *, is_package: bool) -> Iterator[str]:
    """Every name that is imported, and each package above the module.

    A study that is named in a text is run as a process of its own.
    """
    parts = module.split(".")
    yield from (".".join(parts[:i]) for i in range(1, len(parts)))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = parts[: len(parts) - node.level + is_package] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            yield from (base, *(f"{base}.{alias.name}" for alias in node.names))
        elif _is_study(node):
            yield str(node.value)


def _is_study(node: ast.AST) -> TypeGuard[ast.Constant]:
    if not isinstance(node, ast.Constant) or not isinstance(node.value, str):
        return False
    return STUDY.fullmatch(node.value) is not None


def _is_text(node: ast.stmt) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )
