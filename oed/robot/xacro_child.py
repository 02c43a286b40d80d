"""Expands one xacro file to standard output: run as a program, in a process of its own.

Xacro evaluates Python expressions of the file, so that a file may ask for any amount of time and
memory: here both are bounded.
"""

from __future__ import annotations

import importlib.util
import json
import resource
import sys
from pathlib import Path

import xacro
from xacro import substitution_args

MEMORY = 2_000_000_000  # [bytes]; expanding a humanoid takes a twentieth


def main() -> None:
    """As JSON on standard input: the file, seconds of CPU that it may take, its own arguments."""
    request = json.load(sys.stdin)
    path, seconds = request["path"], request["seconds"]
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    beside = Path(__file__).with_name("packages.py")
    specification = importlib.util.spec_from_file_location("packages", beside)
    if specification is None or specification.loader is None:
        raise RuntimeError(f"{beside} is missing")
    packages = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(packages)

    def find(name: str) -> str:
        folder = packages.find_package(name, Path(path))
        if folder is None:
            raise substitution_args.SubstitutionException(
                f"package {name!r} is neither in ROS_PACKAGE_PATH or AMENT_PREFIX_PATH nor among "
                "the folders above the file"
            )
        return str(folder)

    # Xacro itself looks where ROS 2 is installed only.
    substitution_args._eval_find = find  # noqa: SLF001
    substitution_args._eval_dict["find"] = find  # noqa: SLF001
    sys.stdout.write(xacro.process_file(path, mappings=request["mappings"]).toxml())


if __name__ == "__main__":
    main()
