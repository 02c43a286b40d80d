"""The arm, its loads and its gains nearest to an estimate, every body one that can exist.

Nearest in the estimate's own metric, as of a single load: one convex problem over the ten parameters of
every link and load, friction and rotors that are not negative, and the logarithms of the gains.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.feasible.coordinates import ENTRIES, Coordinates
from oed.estimation.feasible.feasible_set import MARGIN, FeasibleSet, Rows, inequality_rows
from oed.estimation.feasible.problem import FeasibleProblem
from oed.estimation.feasible.reference import scaled_neutral_bodies
from oed.estimation.feasible.regularisation import Regularisation
from oed.estimation.feasible.solve import FeasibleSolution, solve_problem
from oed.estimation.load.consistent_body import LEAST_MASS, PULL, ball
from oed.estimation.load.current_equations import CurrentEquations
from oed.estimation.load.gain_fit import GainFit
from oed.estimation.triangular import augment, triangularise


@dataclass(frozen=True)
class ConsistentArm:
    """Bodies that can exist, and the gains that go with them.

    Attributes:
        links: (n, 10) of the arm, about their joints' body frames.
        loads: (k, 10) likewise.
        log_k: (n,) logarithm of the gains [N m or N per A].
        solution: The proof that they are the nearest.
    """

    links: Float[ndarray, "links 10"]
    loads: Float[ndarray, "loads 10"]
    log_k: Float[ndarray, " joints"]
    solution: FeasibleSolution


def consistent_arm(equations: CurrentEquations, found: GainFit) -> ConsistentArm:
    """The consistent arm nearest to a fit.

    Raises:
        SolverFailed: If no solver came to any point.
    """
    n, loads = equations.joints, len(equations.loads)
    to_x, kept = _to_estimate(equations)
    covariance = found.covariance[np.ix_(kept, kept)]
    scale = np.sqrt(np.diag(covariance))
    lower = np.linalg.cholesky(covariance / np.outer(scale, scale))
    whitener = np.linalg.inv(lower) / scale
    square = triangularise(augment(whitener @ to_x, whitener @ found.x[kept]))
    factor, target = square[:-1, :-1], square[:-1, -1]
    links = scaled_neutral_bodies(equations.model.arm.robot, factor, target)
    held = [_ball(equations, found, load) for load in range(loads)]
    reference = np.concatenate([links, *held])
    effects = factor[:, len(reference) :]
    norms = np.linalg.norm(effects, axis=0)
    coordinates = Coordinates.relative_to(reference, 1 / np.where(norms > 0, norms, 1.0))
    # A link of which nothing is determined is left to the pull alone.
    triangle = triangularise(augment(factor @ coordinates.to_parameters, target))
    problem = FeasibleProblem(
        coordinates=coordinates,
        factor=triangle[:-1, :-1],
        target=triangle[:-1, -1],
        constant=float(square[-1, -1] ** 2 + triangle[-1, -1] ** 2),
        rows=1,
        margin=MARGIN,
        inequality=_asked(equations, coordinates),
        equality=_known(equations, coordinates),
        regularisation=Regularisation(PULL),
    )
    solution = solve_problem(problem)
    parameters = coordinates.parameters(solution.x)
    bodies = parameters[: len(reference)].reshape(-1, ENTRIES)
    return ConsistentArm(bodies[:n], bodies[n:], -parameters[-n:], solution)


def _to_estimate(
    equations: CurrentEquations,
) -> tuple[Float[ndarray, "kept parameters"], list[int]]:
    """What of x the parameters are, and which of x: friction's changes are nobody's parameter."""
    n, places = equations.joints, equations.places
    model, inertial = equations.model, ENTRIES * equations.joints
    loads = ENTRIES * len(equations.loads)
    own = len(model.arm.parameters)
    width = own + loads + 2 * n
    whole = np.zeros((equations.size, width))
    regrouping = model.base.regrouping
    whole[places["beta"], :inertial] = regrouping[:, :inertial]
    whole[places["beta"], inertial + loads : own + loads] = regrouping[:, inertial:]
    row = places["phi"].start
    for load, free in enumerate(equations.free):
        for k in free:
            whole[row, inertial + ENTRIES * load + k] = 1.0
            row += 1
    whole[places["mu"], width - 2 * n : width - n] = np.eye(n)
    whole[places["log_u"], width - n :] = np.eye(n)
    change = set(range(*places["change"].indices(equations.size)))
    kept = [k for k in range(equations.size) if k not in change]
    return whole[kept], kept


def _ball(equations: CurrentEquations, found: GainFit, load: int) -> Float[ndarray, "10"]:
    body = equations.body(found.x, load)
    mass = max(float(body[0]), LEAST_MASS)
    model = equations.loaded[load].model
    told = np.isin([1, 2, 3], model.kept)
    return ball(mass, np.where(told, body[1:4] / mass, model.frame.p_JF))


def _asked(equations: CurrentEquations, coordinates: Coordinates) -> Rows:
    """What effects ask of their parameters, and that gears lose and do not gain."""
    arm, n = equations.model.arm, equations.joints
    own = inequality_rows(FeasibleSet.of(arm), arm)
    inertial, loads = ENTRIES * n, ENTRIES * len(equations.loads)
    matrix = np.zeros((len(own) + n, coordinates.size))
    matrix[: len(own), :inertial] = own.matrix[:, :inertial]
    matrix[: len(own), inertial + loads : -2 * n] = own.matrix[:, inertial:]
    matrix[len(own) :, -2 * n : -n] = np.eye(n)
    bound = np.append(own.bound, np.zeros(n))
    matrix = matrix @ coordinates.to_parameters
    lengths = np.linalg.norm(matrix, axis=1)
    names = (*own.names, *(f"mu_{j + 1} >= 0" for j in range(n)))
    return Rows(matrix / lengths[:, None], bound / lengths, names)


def _known(equations: CurrentEquations, coordinates: Coordinates) -> Rows:
    """Masses and centres that are given, as rows of the unknowns, each of unit length."""
    rows, bounds, names = [], [], []
    for load, known in enumerate(equations.loads):
        start = ENTRIES * (equations.joints + load)
        for k, value in known.fixed(equations.loaded[load].model).items():
            row = coordinates.to_parameters[start + k]
            length = np.linalg.norm(row)
            rows.append(row / length)
            bounds.append(value / length)
            names.append(f"parameter {k} of load {load + 1} = {value:g}")
    return Rows(np.array(rows).reshape(-1, coordinates.size), np.array(bounds), tuple(names))
