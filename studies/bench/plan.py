"""Which data sets the bench makes, in the order in which they are worth making."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import numpy as np

from studies.bench.case import Case, NoiseKind
from studies.bench.forms import WAVES, Kind, forms_of

TWO_JOINTS = ("scara", "vertical")
MANY_JOINTS = ("ur5", "panda")
GROUPS = ("clean", "single", "other_formula", "outside", "pair", "size", "many_joints")
SIZES = (0.0625, 0.125, 0.25, 0.5, 2.0)
# One friction, one position, one drive and one measurement effect for the curve of detection.
SIZED = ("stribeck", "position_friction", "ripple", "spring", "gain", "lagging_torque")
CLEAN_KINDS: tuple[tuple[NoiseKind, bool], ...] = (
    ("white", True),
    ("coloured", True),
    ("felt", True),
    ("coloured", False),
)
ONE_EFFECT: tuple[tuple[Kind, str], ...] = (
    ("plain", "single"),
    ("other_formula", "other_formula"),
    ("outside", "outside"),
)
SPRUNG = {"loose_gear", "elastic"}  # an arm of the bench has one joint with a spring at most
PAIRS_A_ROUND = 5
STREAMS = (29, 31)  # of the seeds of each later wave of forms
MANY_JOINT_FORMS = (
    "",
    "stribeck",
    "spring",
    "gain",
    "late_torque",
    "load_friction",
    "tilted_base",
    "ripple",
    "neighbour_motor",
)


def plan(seeds: int, groups: Sequence[str] = GROUPS, *, first: int = 0) -> list[Case]:
    """All cases of the given groups, round by round, each round shuffled.

    A run that ends early has then seen a fair sample.

    Args:
        seeds: Number of rounds.
        groups: Of `GROUPS`.
        first: Seed of the first round.

    Raises:
        ValueError: If there is no such group.
    """
    unknown = set(groups) - set(GROUPS)
    if unknown:
        raise ValueError(f"no groups {sorted(unknown)}; there are {list(GROUPS)}")
    cases: list[Case] = []
    for seed in range(first, first + seeds):
        found = [case for case in _round(seed) if case.group in groups]
        order = np.random.default_rng([seed, 715]).permutation(len(found))
        cases += [found[i] for i in order]
    return cases


def smoke() -> list[Case]:
    """One small case."""
    return [Case("single", "scara", ("constant",), 1.0, "white", True, 0)]


def _round(seed: int) -> Iterator[Case]:
    rng = np.random.default_rng([seed, 23])
    for robot in TWO_JOINTS:
        for noise, repeated in CLEAN_KINDS:
            yield Case("clean", robot, (), 1.0, noise, repeated, seed)
    for kind, group in ONE_EFFECT:
        yield from _one_effect(kind, group, seed, rng, WAVES[0])
    yield from _pairs(seed, rng)
    for form in SIZED:
        size = float(rng.choice(SIZES))
        robot = str(rng.choice(TWO_JOINTS))
        yield Case("size", robot, (form,), size, *_setting(rng), seed)
    for index, robot in enumerate(MANY_JOINTS):
        key = MANY_JOINT_FORMS[(2 * seed + index) % len(MANY_JOINT_FORMS)]
        yield Case("many_joints", robot, (key,) if key else (), 1.0, "white", index == 0, seed)
    for wave, stream in zip(WAVES[1:], STREAMS, strict=True):
        own = np.random.default_rng([seed, stream])
        for kind, group in ONE_EFFECT:
            yield from _one_effect(kind, group, seed, own, wave)


def _one_effect(
    kind: Kind, group: str, seed: int, rng: np.random.Generator, wave: Collection[str]
) -> Iterator[Case]:
    """Each form of a kind and a wave on one of the two arms, the other one in the next round."""
    shown = {robot: {form.key for form in forms_of(kind, robot)} for robot in TWO_JOINTS}
    keys = {key for robot in TWO_JOINTS for key in shown[robot] if key in wave}
    for index, key in enumerate(sorted(keys)):
        robot = TWO_JOINTS[(seed + index) % 2]
        if key not in shown[robot]:
            robot = TWO_JOINTS[(seed + index + 1) % 2]
        yield Case(group, robot, (key,), 1.0, *_setting(rng), seed)


def _pairs(seed: int, rng: np.random.Generator) -> Iterator[Case]:
    """Two effects that do not both change the whole arm, or put a spring in it."""
    for number in range(PAIRS_A_ROUND):
        robot = TWO_JOINTS[(seed + number) % 2]
        forms = [f for f in forms_of("plain", robot) if f.key in WAVES[0]]
        of_a_joint = [f.key for f in forms if not f.whole_arm]
        first = str(rng.choice(of_a_joint))
        excluded = SPRUNG if first in SPRUNG else {first}
        second = str(rng.choice([f.key for f in forms if f.key not in excluded]))
        yield Case("pair", robot, (first, second), 1.0, *_setting(rng), seed)


def _setting(rng: np.random.Generator) -> tuple[NoiseKind, bool]:
    """Noise and repetition: half white, three quarters repeated."""
    kinds: tuple[NoiseKind, ...] = ("white", "white", "coloured", "felt")
    return kinds[rng.integers(4)], bool(rng.random() < 0.75)
