"""What is demanded of the parameters, besides explaining the torque."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.dynamics.effects import with_columns
from oed.dynamics.effects.parameter import Demand
from oed.dynamics.torque_model import TorqueModel
from oed.robot.inertia import PARAMETER_SYMBOLS, pseudo_inertia

# Every link keeps at least this share of its reference body, in every direction: enough to
# stay clear of rounding, too little to be felt in a torque.
MARGIN = 1e-4


@dataclass(frozen=True)
class MassRegion:
    """A region that holds all the mass of a link: <Q, J> >= 0 for each of its matrices.

    With the homogeneous point y = (r, 1), y^T Q y >= 0 throughout the region; the integral of
    that over the mass is <Q, J> (Wensing, Kim and Slotine 2018, section IV).

    Attributes:
        link: Index of the link.
        matrices: (k, 4, 4) symmetric Q.
        name: Of the region, for messages.
    """

    link: int
    matrices: Float[ndarray, "k 4 4"]
    name: str

    @classmethod
    def box(
        cls,
        link: int,
        lower: Float[ndarray, "3"],
        upper: Float[ndarray, "3"],
        *,
        R_JB: Float[ndarray, "3 3"] | None = None,
        p_JB: Float[ndarray, "3"] | None = None,
        name: str = "box",
    ) -> MassRegion:
        """A box, given in a frame B that is posed in the body frame J [m].

        The product of the distances from any two faces is not negative inside.
        """
        if not np.all(lower < upper):
            raise ValueError(f"box of link {link}: lower {lower} is not below upper {upper}")
        R = np.eye(3) if R_JB is None else R_JB
        p = np.zeros(3) if p_JB is None else p_JB
        faces = []
        for axis in range(3):
            normal = R[:, axis]
            faces.append(np.append(normal, -normal @ p - lower[axis]))
            faces.append(np.append(-normal, normal @ p + upper[axis]))
        inside = np.array([0.0, 0.0, 0.0, 1.0])
        pairs = [(a, b) for k, a in enumerate(faces) for b in (*faces[k + 1 :], inside)]
        matrices = np.array([0.5 * (np.outer(a, b) + np.outer(b, a)) for a, b in pairs])
        return cls(link, matrices, name)


@dataclass(frozen=True)
class FeasibleSet:
    """Demands on the parameters of a torque model.

    Attributes:
        margin: Least eigenvalue of each link's pseudo-inertia relative to its reference body.
        regions: Where the mass of a link must lie; several of one link all hold.
        total_mass: Of all moving links [kg].
        known_masses: Mass of a link [kg] by its index.
        effects: What each effect asks of its own parameters, and the first of their columns.
    """

    margin: float = MARGIN
    regions: tuple[MassRegion, ...] = ()
    total_mass: float | None = None
    known_masses: Mapping[int, float] = field(default_factory=dict)
    effects: tuple[tuple[int, Demand], ...] = ()

    def __post_init__(self) -> None:
        if not 0 < self.margin < 1:
            raise ValueError(f"margin {self.margin:g} must lie between 0 and 1")
        if self.total_mass is not None and not self.total_mass > 0:
            raise ValueError(f"total mass {self.total_mass:g} kg must be positive")

    @classmethod
    def of(cls, model: TorqueModel) -> FeasibleSet:
        """Consistent links, and what every effect asks, such as friction that is not negative."""
        return cls(
            effects=tuple(
                (place.start, demand)
                for effect, place in with_columns(model.effects)
                for demand in effect.demands
            )
        )

    def with_(
        self,
        *,
        margin: float | None = None,
        regions: tuple[MassRegion, ...] | None = None,
        total_mass: float | None = None,
        known_masses: Mapping[int, float] | None = None,
    ) -> FeasibleSet:
        """This set with what is given put in the place of what was there."""
        given = {
            "margin": margin,
            "regions": regions,
            "total_mass": total_mass,
            "known_masses": known_masses,
        }
        return dataclasses.replace(self, **{k: v for k, v in given.items() if v is not None})


@dataclass(frozen=True)
class Rows:
    """Linear demands on parameters: C pi >= d, or C pi = d.

    Attributes:
        matrix: (k, p) C.
        bound: (k,) d.
        names: (k,) what each demands.
    """

    matrix: Float[ndarray, "k p"]
    bound: Float[ndarray, " k"]
    names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.bound)


def inequality_rows(demands: FeasibleSet, model: TorqueModel) -> Rows:
    """Mass regions, and what effects ask, as C pi >= d."""
    names = [parameter.name for parameter in model.parameters]
    matrix, bounds, texts = [], [], []
    for region in demands.regions:
        for Q in region.matrices:
            row = np.zeros(len(names))
            row[10 * region.link : 10 * region.link + 10] = _by_parameters(Q)
            matrix.append(row)
            bounds.append(0.0)
            texts.append(f"mass of {model.robot.joints[region.link].link} inside its {region.name}")
    for column, demand in demands.effects:
        row = np.zeros(len(names))
        row[column : column + len(demand.weights)] = demand.weights
        matrix.append(row)
        bounds.append(demand.bound)
        texts.append(demand.words)
    stacked = np.array(matrix).reshape(-1, len(names))
    return Rows(stacked, np.array(bounds), tuple(texts))


def least_values(model: TorqueModel) -> Float[ndarray, " p"]:
    """(p,) what each parameter is at least, whatever the others are; -inf where it may be anything.

    Masses and moments of inertia of a consistent link are positive, and an effect has its own demands.
    """
    least = np.full(len(model.parameters), -np.inf)
    for k, symbol in enumerate(PARAMETER_SYMBOLS):
        if symbol in ("m", "Ixx", "Iyy", "Izz"):
            least[k : 10 * model.robot.n : 10] = 0.0
    for column, demand in FeasibleSet.of(model).effects:
        own = np.flatnonzero(demand.weights)
        if len(own) == 1 and demand.weights[own[0]] > 0:
            least[column + own[0]] = demand.bound / demand.weights[own[0]]
    return least


def equality_rows(demands: FeasibleSet, model: TorqueModel) -> Rows:
    """Known masses as C pi = d."""
    count = len(model.parameters)
    matrix, bound, texts = [], [], []
    if demands.total_mass is not None:
        row = np.zeros(count)
        row[: 10 * model.robot.n : 10] = 1.0
        matrix.append(row)
        bound.append(demands.total_mass)
        texts.append(f"total mass = {demands.total_mass:g} kg")
    for link, mass in sorted(demands.known_masses.items()):
        if not 0 <= link < model.robot.n:
            raise ValueError(f"a mass is given for link {link}; there are {model.robot.n}")
        matrix.append(np.eye(count)[10 * link])
        bound.append(mass)
        texts.append(f"mass of {model.robot.joints[link].link} = {mass:g} kg")
    return Rows(np.array(matrix).reshape(-1, count), np.array(bound, dtype=float), tuple(texts))


def _by_parameters(Q: Float[ndarray, "4 4"]) -> Float[ndarray, "10"]:
    """<Q, J> as a row over the ten parameters."""
    return np.array([float(np.sum(Q * pseudo_inertia(unit))) for unit in np.eye(10)])
