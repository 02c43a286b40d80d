"""Numbers that a study takes on its command line, refused where they make no sense."""

from __future__ import annotations

import argparse
from functools import partial


def _whole_number(text: str, *, least: int) -> int:
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if value < least:
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number from {least} on")
    return value


# Types for `ArgumentParser.add_argument`: of what there must be one at least, and of seeds.
from_one = partial(_whole_number, least=1)
from_zero = partial(_whole_number, least=0)
