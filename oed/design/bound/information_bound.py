"""The bound on log det Lambda: columns are generated until the dual is feasible everywhere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.design.bound.balance import Monomials
from oed.design.bound.branch_and_bound import ProvenMaximum, prove_maximum
from oed.design.bound.deadline import NEVER, Deadline, OutOfTime
from oed.design.bound.state_information import StateInformation, dual_values
from oed.design.bound.states import ViableStates
from oed.design.bound.weights import WeightedDesign, WeightsNotFound, optimal_weights
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.torque_model import TorqueModel
from oed.robot import JointLimits

KEPT_SLACK = (
    0.3  # atoms further below the dual's maximum are dropped, relative to it; they may come again
)
KEPT_WEIGHT = 1e-9  # unless they have a weight


@dataclass(frozen=True)
class BoundSettings:
    """How hard to work.

    Attributes:
        degree: Highest total degree of the test functions.
        even: Whether odd total degrees are left out; see `Monomials.up_to`.
        first_atoms: Random states to begin with.
        rounds: Of column generation at most.
        states_per_round: Random states looked at in each.
        tolerance: At which generation ends: excess of the dual over its least, relative.
        proof_tolerance: Of branch and bound, relative.
        most_boxes: Of branch and bound.
    """

    degree: int = 6
    even: bool = True
    first_atoms: int = 6000
    rounds: int = 25
    states_per_round: int = 40_000
    tolerance: float = 0.005
    proof_tolerance: float = 0.005
    most_boxes: int = 2_000_000


@dataclass(frozen=True)
class InformationBound:
    """An upper bound on the information of every motion within the limits.

    Attributes:
        kind: "certified" if the dual was checked over the whole set of states, "estimated" if
            only where a search looked.
        log10_det: Bound on log10 det of the mean information of one instant, all joints.
        attained: The same of the best measure found: no bound of this kind can be below.
        excess: The dual's maximum over its least, minus 1; what tightening is left.
        information: (b, b) of the best measure.
        functions: Number of test functions.
        boxes: Boxes that the proof took; 0 if estimated.
        longest_return: Time from any admissible state to any other [s].
    """

    kind: Literal["certified", "estimated"]
    log10_det: float
    attained: float
    excess: float
    information: Float[ndarray, "base base"]
    functions: int
    boxes: int
    longest_return: float

    @classmethod
    def of_measure(
        cls,
        information: Float[ndarray, "base base"],
        highest: float,
        *,
        kind: Literal["certified", "estimated"],
        functions: int,
        boxes: int,
        longest_return: float,
    ) -> InformationBound:
        """The bound that a measure's inverse information M gives.

        tr(M Lambda) <= highest for every measure, so det Lambda <= (highest / b)^b / det M.

        Args:
            information: (b, b) of the measure.
            highest: Maximum of the dual over all states.
            kind: As the attribute, and so are the rest.
            functions: Of the dual.
            boxes: Of the proof.
            longest_return: Of the states.
        """
        b = len(information)
        attained = float(np.linalg.slogdet(information)[1] / np.log(10))
        return cls(
            kind=kind,
            log10_det=attained + b * float(np.log10(highest / b)),
            attained=attained,
            excess=highest / b - 1,
            information=information,
            functions=functions,
            boxes=boxes,
            longest_return=longest_return,
        )

    @property
    def size(self) -> int:
        """Number of parameters b."""
        return len(self.information)

    def J_d(self, instants: int, horizon: float | None = None) -> float:  # noqa: N802 - the paper's symbol
        """The bound on J_d of that many instants, as their mean information times them.

        Args:
            instants: N of the criterion.
            horizon: None for a periodic motion. For one of that length [s] that is not, but
                that the arm can come to from rest and stop after: then a way back of
                `longest_return` makes it periodic, and can only add information.
        """
        longer = 1.0 if horizon is None else 1.0 + self.longest_return / horizon
        return self.log10_det + self.size * float(np.log10(instants * longer))

    def efficiency(self, J_d: float, instants: int, horizon: float | None = None) -> float:
        """D-efficiency of a design, (det Lambda / det bound)^(1/b); arguments as for `J_d`."""
        return float(10 ** ((J_d - self.J_d(instants, horizon)) / self.size))


def information_bound(
    model: TorqueModel,
    base: BaseParameters,
    limits: JointLimits,
    rng: np.random.Generator,
    *,
    covariance: Float[ndarray, "..."] | None = None,
    settings: BoundSettings | None = None,
    certify: bool | None = None,
    deadline: Deadline = NEVER,
) -> InformationBound:
    """Bound log10 det of the mean information of every periodic motion within the limits.

    Args:
        model: The torque model.
        base: Its base parameters.
        limits: Of position, velocity and acceleration; others are left out, which keeps the
            bound valid.
        rng: Source of the random states; the proof does not depend on it.
        covariance: R_v at one instant; the identity if None.
        settings: How hard to work.
        certify: Whether to prove the bound; by default up to two joints.
        deadline: When to stop; the lowest bound until then counts.

    Raises:
        ValueError: If the set of states is not bounded or the model not affine in acceleration.
        WeightsNotFound: If the weights of the atoms cannot be found.
        OutOfTime: If there is no bound at the deadline.
    """
    settings = settings or BoundSettings()
    states = ViableStates(limits)
    centre = limits.position.mean(axis=1)
    scale = np.concatenate([np.diff(limits.position, axis=1)[:, 0] / 2, states.fastest])
    functions = Monomials.up_to(settings.degree, centre, scale, even=settings.even)
    source = StateInformation(model, base, states, functions, covariance)
    certify = states.joints <= 2 if certify is None else certify
    bounds: list[InformationBound] = []
    try:
        for design, highest, boxes in _tighten(source, rng, settings, certify, deadline):
            bound = InformationBound.of_measure(
                design.information,
                highest,
                kind="certified" if boxes else "estimated",
                functions=len(functions),
                boxes=boxes,
                longest_return=states.longest_return,
            )
            bounds.append(bound)
    except OutOfTime:
        if not bounds:
            raise
    return min(bounds, key=lambda bound: bound.log10_det)


def _tighten(
    source: StateInformation,
    rng: np.random.Generator,
    settings: BoundSettings,
    certify: bool,
    deadline: Deadline,
) -> Iterator[tuple[WeightedDesign, float, int]]:
    """Designs of ever more atoms, each with the dual's maximum and the boxes that prove it.

    Where the random search finds no violation any more, branch and bound looks; what it finds
    become atoms too. Without proof there is one design, and the maximum is the search's.
    """
    x, ddq = source.states.sample(settings.first_atoms, rng)
    atoms = (x, ddq, *source.atoms(x, ddq))
    design = optimal_weights(*atoms[2:], deadline=deadline)
    highest, is_proven = np.inf, False
    for _ in range(settings.rounds):
        deadline.check()
        more, highest = _search(source, design, (x, ddq, design.weights), rng, settings)
        if highest <= (1 + settings.tolerance) * design.mass_multiplier:
            if not certify:
                break
            proof = _prove(source, design, settings, deadline)
            yield design, proof.upper, proof.boxes
            is_proven = True
            if proof.attained <= (1 + settings.tolerance) * design.mass_multiplier:
                return
            more = _worth_adding(source, design, proof, settings)
        value = dual_values(design, *atoms[2:])
        kept = value > (1 - KEPT_SLACK) * design.mass_multiplier
        kept |= design.weights > KEPT_WEIGHT
        x, ddq, rows, rates = (
            np.concatenate([old[kept], new]) for old, new in zip(atoms, more, strict=True)
        )
        atoms = (x, ddq, rows, rates)
        try:
            design = optimal_weights(rows, rates, deadline=deadline)
        except WeightsNotFound:
            if is_proven:  # what is proven stays proven
                return
            raise
    if not certify:
        yield design, highest, 0
    elif not is_proven:
        proof = _prove(source, design, settings, deadline)
        yield design, proof.upper, proof.boxes


def _worth_adding(
    source: StateInformation,
    design: WeightedDesign,
    proof: ProvenMaximum,
    settings: BoundSettings,
) -> tuple[ndarray, ndarray, ndarray, ndarray]:
    """States found by branch and bound at which the dual is too large."""
    rows, rates = source.atoms(proof.points, proof.fixed)
    value = dual_values(design, rows, rates)
    much = value > design.mass_multiplier * (1 + settings.tolerance / 2)
    much[value.argmax()] = True
    return proof.points[much], proof.fixed[much], rows[much], rates[much]


def _search(
    source: StateInformation,
    design: WeightedDesign,
    support: tuple[ndarray, ndarray, ndarray],
    rng: np.random.Generator,
    settings: BoundSettings,
) -> tuple[tuple[ndarray, ndarray, ndarray, ndarray], float]:
    """States where the dual is largest, random ones and neighbours of the support, and how large."""
    x, ddq, weights = support
    lower, upper = source.states.box.T
    fresh = source.states.sample(settings.states_per_round // 2, rng)
    count = settings.states_per_round - len(fresh[0])
    chosen = rng.choice(len(x), size=count, p=weights / weights.sum())
    reach = 10.0 ** rng.uniform(-3, -0.5, (count, 1))
    moved = x[chosen] + reach * (upper - lower) * rng.standard_normal((count, len(lower)))
    candidates = (
        np.concatenate([fresh[0], np.clip(moved, lower, upper)]),
        np.concatenate([fresh[1], ddq[chosen]]),
    )
    rows, rates = source.atoms(*candidates)
    value = dual_values(design, rows, rates)
    best = np.argsort(-value)[: max(200, 4 * len(source.functions))]
    best = best[value[best] > design.mass_multiplier * (1 - settings.tolerance)]
    if not len(best):
        best = np.array([int(value.argmax())])
    found = (candidates[0][best], candidates[1][best], rows[best], rates[best])
    return found, float(max(value.max(), design.mass_multiplier))


def _prove(
    source: StateInformation,
    design: WeightedDesign,
    settings: BoundSettings,
    deadline: Deadline,
) -> ProvenMaximum:
    return prove_maximum(
        source.dual(design),
        source.boxes(),
        tolerance=settings.proof_tolerance,
        at_least=design.mass_multiplier,
        most_boxes=settings.most_boxes,
        deadline=deadline,
    )
