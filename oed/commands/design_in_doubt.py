"""`oed design --robust`: the motion for all models that data do not tell from one."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.commands.configurations import Design
from oed.commands.design_of_model import scenarios_of
from oed.commands.telling import say
from oed.design.clear_search import ClearSearch, search_clear
from oed.design.collision import Surroundings
from oed.design.design import Design as FoundDesign
from oed.design.design import prove
from oed.design.optimisers.registry import Optimiser
from oed.design.optimisers.result import Budget
from oed.design.optimisers.warm_start import from_motion
from oed.design.problem import DesignProblem
from oed.design.robust_problem import RobustProblem
from oed.design.robust_worth import RobustWorth, torque_of_drawn
from oed.design.status import LimitStatus

SAME_INFORMATION = (
    "information does not depend on the values of linear parameters, and no shape was drawn that a column "
    "depends on: the criterion is the same under every drawn model, which count against torque limits alone"
)
NO_BETTER = (
    "no motion was found that is better under the drawn models than the one for the nominal model, which "
    "keeps their torque limits as well: it is the answer; more --evaluations may find another"
)


@dataclass(frozen=True)
class SearchInDoubt:
    """What was found.

    Attributes:
        search: The motion that was asked for.
        nominal: (size,) that for the nominal model alone; None where that is what was asked for.
        notes: What is to be said of it.
    """

    search: ClearSearch
    nominal: Float[ndarray, " size"] | None = None
    notes: tuple[str, ...] = ()


def robust_of(
    problem: DesignProblem, config: Design
) -> tuple[RobustProblem | DesignProblem, tuple[str, ...]]:
    """The problem under drawn models where that is asked for, and what was drawn.

    Raises:
        NoUsableResult: If nothing depends on what is in doubt, or no model can be drawn.
    """
    if config.robust == "no":
        return problem, ()
    scenarios, told = scenarios_of(Path(config.model), problem, config.scenarios, config.seed)
    robust = RobustProblem.of(problem, config.robust, scenarios)
    return robust, (*told, *(() if robust.has_shapes else (SAME_INFORMATION,)))


def search_in_doubt(
    problem: DesignProblem,
    surroundings: Surroundings | None,
    budget: Budget,
    rng: np.random.Generator,
    optimise: Optimiser,
) -> SearchInDoubt:
    """Search for a motion; under drawn models first for that of the nominal one, which it is held against.

    Each search has the whole budget and the same random numbers; the second goes on from the first one's
    answer. Where the nominal motion keeps torque limits under every drawn model and is better under them
    too, it is taken.

    Args:
        problem: To solve.
        surroundings: As for `search_clear`, and so are the next.
        budget: Of each search.
        rng: Of the starts.
        optimise: Of the first of both searches.
    """
    if not isinstance(problem, RobustProblem):
        return SearchInDoubt(search_clear(problem, surroundings, budget, rng, optimise))
    say("searching for the nominal model's motion, then for the drawn models'")
    again = copy.deepcopy(rng)
    plain = search_clear(problem.alone, surroundings, budget, again, optimise)
    nominal = plain.found.z
    search = search_clear(problem, surroundings, budget, rng, from_motion(optimise, nominal))
    is_kept = problem.torque_factor(nominal) == 1.0
    if is_kept and problem.cost(nominal) <= problem.cost(search.found.z):
        return SearchInDoubt(plain, nominal, (NO_BETTER,))
    return SearchInDoubt(search, nominal)


def worth_in_doubt(
    problem: DesignProblem, nominal: Float[ndarray, " size"] | None, z: Float[ndarray, " size"]
) -> RobustWorth | None:
    """Both motions under the drawn models; None where none were drawn."""
    if nominal is None or not isinstance(problem, RobustProblem):
        return None
    return RobustWorth.of(problem, prove(problem.alone, nominal)[0], z)


def torque_in_doubt(design: FoundDesign) -> tuple[LimitStatus, ...]:
    """Whether torque limits are kept under every drawn model; nothing where none were drawn."""
    problem = design.problem
    if not isinstance(problem, RobustProblem):
        return ()
    return torque_of_drawn(problem, design.z, design.certificate)
