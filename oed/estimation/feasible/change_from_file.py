"""What an estimate makes of the robot file's links: before, after, and whether the data asked for it.

A value moved beyond reason if the data alone do not determine it and it is another body's: a mass that is off
by more than makers' are, moments about the centre of mass that doubled or halved, or a centre so far that the
moment about where it was doubled, J + m d^2 > 2 J, which is by the radius of gyration.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from scipy.linalg import svd

from oed.estimation.feasible.bootstrap import interval_about
from oed.estimation.feasible.coordinates import ENTRIES
from oed.estimation.feasible.problem import FeasibleProblem

# Share of a mass. Makers' masses of whole links agree with identified ones within some ten per cent where
# both are told apart (Gaz and others 2019, Panda): beyond three times that is another body.
MASS = 0.3
FACTOR = (
    2.0  # of moments, which no maker's table has been held against: twice as much is another body
)
# Standard deviation, per value, up to which least squares on the data alone determine it.
DETERMINED = 0.3
# Share of a unit vector outside the data's row space that is taken for rounding.
OUTSIDE = 1e-4
RANK = 1e-8  # of the largest singular value of columns of unit length
NAMES = ("mass", "centre x", "centre y", "centre z", "inertia")
UNITS = ("kg", "m", "m", "m", "kg m^2")


@dataclass(frozen=True)
class Moved:
    """A value of a link in the file and as identified.

    Attributes:
        name: "mass"; "centre x" and so on, in the body frame; "inertia", the mean of the principal
            moments about the centre of mass.
        unit: Of all numbers here.
        before: In the file.
        after: As identified.
        interval: (2) of that.
        deviation: Its standard deviation by least squares on the data alone, inf where they do not
            depend on it.
        size: What counts as one: the value itself, of a centre the file's radius of gyration.
        reason: (2) least and most that is within reason.
    """

    name: str
    unit: str
    before: float
    after: float
    interval: Float[ndarray, "2"]
    deviation: float
    size: float
    reason: tuple[float, float]

    @property
    def is_determined(self) -> bool:
        """Whether the data alone determine it."""
        return self.deviation <= DETERMINED * self.size

    @property
    def is_unreasonable(self) -> bool:
        """Whether it moved beyond reason without the data determining it."""
        return not self.is_determined and not self.reason[0] <= self.after <= self.reason[1]

    @property
    def words(self) -> str:
        """Before and after, and what is known of it."""
        low, high = self.interval
        known = (
            "no torque in the data depends on it by itself"
            if not np.isfinite(self.deviation)
            else f"the data alone leave it uncertain by {self.deviation:.3g} {self.unit}"
        )
        return (
            f"{self.name} {self.after:.3g} {self.unit}, in the file {self.before:.3g} {self.unit} (95 % "
            f"of resampled estimates: {low:.3g} to {high:.3g} {self.unit}), and {known}"
        )


@dataclass(frozen=True)
class LinkChange:
    """One link, or all of them together.

    Attributes:
        link: Its name; "all links" for the sum.
        mass: Of it.
        centre: (3) along the axes of the body frame; none for the sum.
        inertia: None for the sum.
    """

    link: str
    mass: Moved
    centre: tuple[Moved, ...] = ()
    inertia: Moved | None = None

    @property
    def unreasonable(self) -> tuple[Moved, ...]:
        """What moved beyond reason."""
        every = (self.mass, *self.centre, *(() if self.inertia is None else (self.inertia,)))
        return tuple(moved for moved in every if moved.is_unreasonable)

    @property
    def warning(self) -> str:
        """What moved beyond reason, in words; empty if nothing did."""
        told = "; ".join(moved.words for moved in self.unreasonable)
        remedy = "believe the file, state --total-mass or raise --weight"
        return f"{self.link}: {told}: {remedy}" if told else ""


def link_changes(
    links: tuple[str, ...],
    before: Float[ndarray, " inertial"],
    after: Float[ndarray, " inertial"],
    samples: Float[ndarray, "r p"],
    problem: FeasibleProblem,
    *,
    level: float = 0.95,
) -> tuple[LinkChange, ...]:
    """Each link's change, and that of the total mass.

    Args:
        links: (n,) names.
        before: (10 n,) the file's.
        after: (10 n,) the estimate's.
        samples: Estimates from resampled data.
        problem: Whose data say what they determine.
        level: Of the intervals.
    """
    old, new = (_values(p.reshape(-1, ENTRIES)) for p in (before, after))
    drawn = _values(samples[:, : len(after)].reshape(len(samples), -1, ENTRIES))
    intervals = interval_about(new, drawn, level)
    deviations = deviations_from_data(problem, _slopes(after, problem.coordinates.size))
    total, each = deviations[-1], deviations[:-1].reshape(new.shape)
    changes = []
    for k, link in enumerate(links):
        gyration = float(np.sqrt(old[k, 4] / old[k, 0]))
        mass, *centre, inertia = (
            _moved(
                i,
                old[k, i],
                new[k, i],
                interval=intervals[k, i],
                deviation=each[k, i],
                gyration=gyration,
            )
            for i in range(len(NAMES))
        )
        changes.append(LinkChange(link, mass, tuple(centre), inertia))
    masses = interval_about(np.asarray(new[:, 0].sum()), drawn[:, :, 0].sum(axis=1), level)
    sums = old[:, 0].sum(), new[:, 0].sum()
    whole = _moved(0, *sums, interval=masses, deviation=total, gyration=np.nan)
    return (*changes, LinkChange("all links", whole))


def _moved(
    kind: int,
    before: float,
    after: float,
    *,
    interval: Float[ndarray, "2"],
    deviation: float,
    gyration: float,
) -> Moved:
    is_centre = NAMES[kind].startswith("centre")
    if NAMES[kind] == "mass":
        reason = (before * (1 - MASS), before * (1 + MASS))
    elif is_centre:
        far = (FACTOR - 1) ** 0.5 * gyration
        reason = (before - far, before + far)
    else:
        reason = (before / FACTOR, before * FACTOR)
    return Moved(
        NAMES[kind],
        UNITS[kind],
        float(before),
        float(after),
        interval,
        float(deviation),
        size=gyration if is_centre else abs(float(after)),
        reason=reason,
    )


def _values(parameters: Float[ndarray, "*k 10"]) -> Float[ndarray, "*k 5"]:
    """Mass, centre of mass and mean principal moment about it, of each body."""
    mass, first = parameters[..., :1], parameters[..., 1:4]
    about_origin = parameters[..., [4, 7, 9]].sum(axis=-1, keepdims=True)
    about_centre = about_origin - 2 * (first**2).sum(axis=-1, keepdims=True) / mass
    return np.concatenate([mass, first / mass, about_centre / 3], axis=-1)


def _slopes(after: Float[ndarray, " inertial"], size: int) -> Float[ndarray, "k p"]:
    """Derivatives of the values of all bodies, and of the total mass, by the parameters."""
    bodies = after.reshape(-1, ENTRIES)
    slopes = np.zeros((len(bodies), len(NAMES), size))
    for k, (mass, *first) in enumerate(bodies[:, :4]):
        own, centre = slice(ENTRIES * k, ENTRIES * (k + 1)), np.array(first) / mass
        slopes[k, 0, own][0] = 1.0
        slopes[k, 1:4, own][:, 0] = -centre / mass
        slopes[k, 1:4, own][:, 1:4] = np.eye(3) / mass
        slopes[k, 4, own][[4, 7, 9]] = 1 / 3
        slopes[k, 4, own][1:4] = -4 / 3 * centre
        slopes[k, 4, own][0] = 2 / 3 * centre @ centre
    return np.vstack([slopes.reshape(-1, size), slopes[:, 0].sum(axis=0)])


def deviations_from_data(
    problem: FeasibleProblem, combinations: Float[ndarray, "k p"]
) -> Float[ndarray, " k"]:
    """Standard deviations of combinations of parameters by least squares, without demand or pull.

    Args:
        problem: Its weighted data; a row is taken to have a variance of one.
        combinations: (k, p) rows over the parameters, in their units.

    Returns:
        (k,) in the combinations' units, inf where they leave the data's row space.
    """
    rows = combinations @ problem.coordinates.to_parameters
    lengths = np.linalg.norm(problem.factor, axis=0)
    used = lengths > 0
    # By QR iteration: LAPACK's divide and conquer, NumPy's choice, fails on some triangles.
    _, values, right = svd(
        problem.factor[:, used] / lengths[used], full_matrices=False, lapack_driver="gesvd"
    )
    kept = values > RANK * values[0]
    scaled = rows[:, used] / lengths[used]
    along = scaled @ right[kept].T
    outside = np.linalg.norm(scaled - along @ right[kept], axis=1) > OUTSIDE * np.linalg.norm(
        scaled, axis=1
    )
    outside |= np.any(np.abs(rows[:, ~used]) > 0, axis=1)
    deviations = np.linalg.norm(along / values[kept], axis=1) / np.sqrt(problem.rows)
    return np.where(outside, np.inf, deviations)
