"""Where a result comes from: enough to make it again and to doubt it."""

from __future__ import annotations

import dataclasses
import platform
import subprocess
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from oed.report.json_file import plain_value, write_json

CHECKOUT = Path(__file__).resolve().parents[2]
# The packages whose arithmetic or random streams can move a number.
KEY_PACKAGES = (
    "numpy",
    "scipy",
    "casadi",
    "drake",
    "cvxpy",
    "clarabel",
    "scs",
    "cma",
    "numba",
    "pin",
    "pandas",
    "pyarrow",
    "matplotlib",
)


@dataclass(frozen=True)
class Provenance:
    """The origin of a result.

    Attributes:
        seed: Seed of the random generator; None where nothing random was done.
        configuration: The study's configuration as plain JSON values.
        versions: Version of each key package that is installed.
        commit: Git commit of the code; None outside a checkout.
        dirty: Whether the checkout differed from that commit; None outside a checkout.
        date: When, in UTC, ISO 8601.
        cpu: Name of the processor.
        python: Version of Python.
        platform: Operating system and architecture.
    """

    seed: int | None
    configuration: dict[str, object]
    versions: dict[str, str]
    commit: str | None
    dirty: bool | None
    date: str
    cpu: str
    python: str
    platform: str

    @classmethod
    def collect(cls, configuration: object, *, seed: int | None) -> Provenance:
        """The provenance of a result made here and now.

        Args:
            configuration: The study's configuration, an instance of a dataclass.
            seed: Seed of its random generator.

        Raises:
            ValueError: If the configuration is no instance of a dataclass, or holds NaN.
        """
        if not dataclasses.is_dataclass(configuration) or isinstance(configuration, type):
            raise ValueError(f"not an instance of a dataclass: {configuration!r}")
        settings = {
            f.name: _without_checkout(plain_value(getattr(configuration, f.name), f.name))
            for f in dataclasses.fields(configuration)
        }
        commit, dirty = git_state(Path(__file__).resolve().parent)
        return cls(
            seed=seed,
            configuration=settings,
            versions=package_versions(KEY_PACKAGES),
            commit=commit,
            dirty=dirty,
            date=datetime.now(UTC).isoformat(timespec="seconds"),
            cpu=cpu_name(),
            python=platform.python_version(),
            platform=platform.platform(),
        )

    def write(self, path: str | Path) -> None:
        """Write as JSON, whole or not at all."""
        write_json(path, self)


def _without_checkout(value: object) -> object:
    """Paths inside the checkout made relative to it: where it lies changes no number."""
    if isinstance(value, str):
        return value.removeprefix(f"{CHECKOUT}/")
    if isinstance(value, list):
        return [_without_checkout(item) for item in value]
    if isinstance(value, dict):
        return {key: _without_checkout(item) for key, item in value.items()}
    return value


def package_versions(packages: tuple[str, ...]) -> dict[str, str]:
    """Version of each of these packages; one that is not installed is left out."""
    found = {}
    for package in packages:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def git_state(folder: Path) -> tuple[str | None, bool | None]:
    """Commit and dirty flag of the checkout that tracks a folder.

    Returns:
        (None, None) where there is no git, no checkout, or no commit in it yet.
    """
    commit = _git(folder, "rev-parse", "HEAD")
    # An installed copy may lie in some other project's checkout: that commit is not ours.
    tracked = _git(folder, "ls-files", "--error-unmatch", ".")
    if commit is None or tracked is None:
        return None, None
    # Results are rewritten by the very run that asks: they do not make the code dirty.
    changes = _git(folder, "status", "--porcelain", "--", ":/", ":(top,exclude)results")
    return commit, None if changes is None else bool(changes)


def cpu_name() -> str:
    """Name of the processor, as the kernel gives it."""
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        for line in cpuinfo.read_text(encoding="utf-8", errors="replace").splitlines():
            key, _, name = line.partition(":")
            if key.strip() == "model name" and name.strip():
                return name.strip()
    return platform.processor() or platform.machine() or "unknown"


def _git(folder: Path, *arguments: str) -> str | None:
    try:
        # Without optional locks: a report must not disturb a commit made meanwhile.
        run = subprocess.run(  # noqa: S603 - fixed program, no shell
            ["git", "--no-optional-locks", "-C", str(folder), *arguments],  # noqa: S607 - PATH is the user's
            capture_output=True,
            text=True,
            check=True,
            timeout=30,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return run.stdout.strip()
