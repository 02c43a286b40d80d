"""A cause: the one thing that is wrong with a log."""

from __future__ import annotations

from dataclasses import dataclass

USELESS = 0.3  # rms residual over rms torque; measured arms reach a few per cent, wrists ten or so


@dataclass(frozen=True)
class Cause:
    """What is wrong with a log.

    Attributes:
        kind: "sign", "position_sign", "order", "position_order", "gravity", "scale", "factor",
            "gear", "offset" or "magnitude".
        text: In words, a sentence without its full stop.
        remedy: What to do about it.
        evidence: What shows it, in words.
    """

    kind: str
    text: str
    remedy: str
    evidence: str
