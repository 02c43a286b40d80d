"""Which joints of a robot's file are the arm: one chain, from the base to where a hand begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

# A branch of no more joints is a finger, a camera mount or a wheel.
FINGER = 2
SHOWN = 3  # other chains that a note spells out


@dataclass(frozen=True)
class ArmChain:
    """The joints taken, and those that might have been taken instead.

    Attributes:
        names: From the base outward.
        others: Chains that leave from a fork of the one taken, each from the base; longest first.
    """

    names: tuple[str, ...]
    others: tuple[tuple[str, ...], ...] = ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Which chain was taken and how to choose another; empty where there is but one."""
        if not self.others:
            return ()
        shown = "; or ".join(" ".join(chain) for chain in self.others[:SHOWN])
        more = len(self.others) - SHOWN
        note = (
            f"this file holds {1 + len(self.others)} chains of joints: {self.names[0]} … "
            f"{self.names[-1]} ({len(self.names)}) was taken; name the joints to take another: "
            f"{shown}{f'; and {more} more' if more > 0 else ''}"
        )
        return (note,)


def find_arm(names: Sequence[str], parents: Sequence[int]) -> ArmChain:
    """Follow the longest chain of a tree of joints to where a hand branches off.

    At a fork the walk follows the branch that is longest, the first in the file of several. It
    ends where that branch is no longer than a finger, or where it has brothers of its kind and is
    no longer than the chain up to there: then these are the fingers of a hand.

    Args:
        names: Of the joints that move.
        parents: For each the index of the joint that carries it; -1 at the base.
    """
    children = {i: [c for c, p in enumerate(parents) if p == i] for i in range(-1, len(names))}
    length: dict[int, int] = {}

    def reach(joint: int) -> int:
        if joint not in length:
            length[joint] = 1 + max((reach(child) for child in children[joint]), default=0)
        return length[joint]

    def longest(joint: int) -> list[int]:
        """The chain from a joint outward, as far as this walk would follow it."""
        return [joint, *walk([joint])]

    others: list[tuple[int, ...]] = []

    def walk(before: list[int], *, taken: bool = False) -> list[int]:
        chain: list[int] = []
        ahead = children[before[-1] if before else -1]
        while ahead:
            # sorted() keeps the order of the file among equals.
            ahead = sorted(ahead, key=reach, reverse=True)
            gone = len(before) + len(chain)
            brothers = [b for b in ahead[1:] if _is_alike(reach(b), reach(ahead[0]))]
            at_hand = reach(ahead[0]) <= FINGER or (brothers and reach(ahead[0]) <= gone)
            if len(ahead) > 1 and gone and at_hand:
                break
            if taken:
                arms = [b for b in ahead[1:] if reach(b) > FINGER or (b in brothers and not gone)]
                others.extend((*before, *chain, *longest(b)) for b in arms)
            chain.append(ahead[0])
            ahead = children[ahead[0]]
        return chain

    taken = walk([], taken=True)
    others.sort(key=len, reverse=True)
    spelled = [tuple(names[i] for i in chain) for chain in others]
    return ArmChain(tuple(names[i] for i in taken), tuple(spelled))


def _is_alike(branch: int, longest: int) -> bool:
    """Whether a branch is of the same kind as the longest: a thumb among fingers."""
    return 2 * branch >= longest
