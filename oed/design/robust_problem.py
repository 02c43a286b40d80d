"""A design for all models that data do not tell from the nominal one.

Values of linear parameters are no part of the information: whatever is drawn of them, Lambda stays,
and they count against torque limits alone. Shapes, such as a Stribeck speed, change columns, and so
each drawn model has an information of its own. The criterion is then the mean over drawn models
(pseudo-Bayesian design: Chaloner and Verdinelli 1995, Statistical Science 10(3), section 5) or the
worst of them (maximin: Pronzato and Walter 1988, Mathematical Biosciences 89(2)).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

from oed.design.criteria import cost, cost_and_slope, soft_maximum
from oed.design.effort import EffortTooSmall, find_stand
from oed.design.nominal_torque import NominalTorque
from oed.design.problem import DENSE, DesignProblem
from oed.design.torque_range import TorqueNotBounded, check_torque_bounded, proven_torque_range
from oed.dynamics.base_parameters import BaseParameters
from oed.dynamics.compiled import CompiledRegressor, compile_columns
from oed.dynamics.effects import Effect, with_columns
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.torque_model import TorqueModel
from oed.errors import NoUsableResult

Aim = Literal["expected", "worst"]
DECADE = np.log(10.0)


@dataclass(frozen=True)
class Scenario:
    """One of the models that data do not tell from the nominal one.

    Attributes:
        model: With as many columns as the nominal one, effect by effect; an effect whose shapes were
            drawn is another object, all others are the nominal model's own.
        parameters: (p,) of it.
    """

    model: TorqueModel
    parameters: Float[ndarray, " parameters"]


@dataclass(frozen=True)
class RobustProblem(DesignProblem):
    """A design problem whose criterion and torque limits are those of drawn models.

    What is reported of its information, as of any problem, is the nominal model's.

    Attributes:
        aim: Whether the mean of the criterion over the drawn models is optimised, or the worst. The
            mean is one of logarithms, as `oed.design.criteria.cost` has them.
        scenarios: The drawn models.
    """

    aim: Aim = dataclasses.field(kw_only=True)
    scenarios: tuple[Scenario, ...] = dataclasses.field(kw_only=True)

    @classmethod
    def of(cls, problem: DesignProblem, aim: Aim, scenarios: Sequence[Scenario]) -> RobustProblem:
        """A problem made robust.

        Args:
            problem: Of the nominal model.
            aim: As the attribute.
            scenarios: Likewise.

        Raises:
            NoUsableResult: If neither information nor a torque limit depends on what was drawn, if
                another shape changes what can be identified, or if drawn models
                cannot stand within the torque limits.
        """
        own = {f.name: getattr(problem, f.name) for f in dataclasses.fields(DesignProblem)}
        robust = cls(**own, aim=aim, scenarios=tuple(scenarios))
        if not (robust.has_shapes or robust.limits_torque):
            raise NoUsableResult(
                "nothing in this design depends on what the model leaves in doubt: information does not "
                "depend on the values of linear parameters, no shape was drawn that a column depends on, "
                "and torque is not limited; the nominal design is the robust one"
            )
        robust._check_identifiable()
        return robust._with_stand() if robust.limits_torque else robust

    @property
    def alone(self) -> DesignProblem:
        """The problem of the nominal model alone."""
        own = {f.name: getattr(self, f.name) for f in dataclasses.fields(DesignProblem)}
        return DesignProblem(**own)

    @property
    def has_shapes(self) -> bool:
        """Whether the information of some drawn model differs from the nominal one's."""
        return len(self._layout.columns) > len(self.base)

    @cached_property
    def regressor(self) -> CompiledRegressor:
        """Of the nominal base columns, and beside them of those that were drawn anew."""
        return compile_columns(self._joined, self._layout.columns, native=self.native)

    def cost(self, z: Float[ndarray, " size"]) -> float:
        """The mean or the worst of the drawn models' criteria, with the exact sign."""
        return self.combined(self.costs(z))

    def costs(self, z: Float[ndarray, " size"]) -> Float[ndarray, " scenarios"]:
        """The criterion of each drawn model, as the logarithm that is minimised."""
        bare = self.fast.information(self.trajectory.motion(z, self.instants))
        found = np.array([cost(own, self.criterion) for own in self._every(bare)])
        return np.broadcast_to(found, len(self.scenarios)).copy() if len(found) == 1 else found

    def combined(self, costs: Float[ndarray, " scenarios"]) -> float:
        """The mean or the worst of some costs."""
        return float(costs.mean() if self.aim == "expected" else costs.max())

    @cached_property
    def not_bounded(self) -> str:
        """Why torque of the drawn models can only be looked at instant by instant; empty if not."""
        try:
            check_torque_bounded(self._joined, self._full)
        except TorqueNotBounded as error:
            return str(error)
        return ""

    def torque_range(self, z: Float[ndarray, " size"]) -> Float[ndarray, "joints 2"] | None:
        """Proven bounds on the torque of the nominal model, and of every drawn one if they can be."""
        if not self.limits_torque or self.not_bounded:
            return super().torque_range(z)
        return proven_torque_range(self._joined, self._full, self.trajectory, z)

    def torque_shares(
        self, z: Float[ndarray, " size"], points: int = DENSE
    ) -> Float[ndarray, "models joints"]:
        """Largest share of each torque limit at many instants: the nominal model's, then the drawn ones'."""
        t = np.linspace(0.0, self.trajectory.horizon, points)
        return self._torque.share(self.regressor.entries(self.trajectory.motion(z, t)))

    @property
    def _joined(self) -> TorqueModel:
        """The nominal model with all effects beside it that were drawn anew."""
        return self.model.with_effects(*self._layout.effects)

    @cached_property
    def _full(self) -> Float[ndarray, "models parameters"]:
        """Parameters of the joined model: the nominal ones, then those of each drawn model."""
        places, count = self._layout.all_places, len(self._joined.parameters)
        full = np.zeros((1 + len(self.scenarios), count))
        if self.nominal is not None:
            full[0, : len(self.nominal)] = self.nominal
        for row, own, each in zip(full[1:], places, self.scenarios, strict=True):
            row[own] = each.parameters
        return full

    @cached_property
    def _torque(self) -> NominalTorque:
        if self.nominal is None:
            raise ValueError("no nominal parameters to limit the torque of")
        layout = self._layout
        weights = np.zeros((1 + len(self.scenarios), len(layout.columns)))
        weights[0, : len(self.base)] = self.base.from_standard(self.nominal)
        drawn = zip(weights[1:], layout.places, self._bases, self.scenarios, strict=True)
        for row, places, base, each in drawn:
            row[places] = base.from_standard(each.parameters)
        return NominalTorque.of(self.regressor, weights, self.limits.torque)

    @cached_property
    def _bases(self) -> list[BaseParameters]:
        """Base parameters of each drawn model, regrouped as its own columns ask."""
        return [
            base_parameters(each.model) if _drawn_anew(self.model, each.model) else self.base
            for each in self.scenarios
        ]

    @property
    def _distinct(self) -> list[Int[ndarray, " base"]]:
        places = self._layout.places
        return places if self.has_shapes else places[:1]

    @cached_property
    def _layout(self) -> _Layout:
        return _Layout.of(self)

    def _every(self, bare: Float[ndarray, "columns columns"]) -> list[Float[ndarray, "base base"]]:
        """Lambda of each drawn model; once where it is the same for all."""
        finish = super()._complete
        return [finish(bare[np.ix_(places, places)]) for places in self._distinct]

    def _complete(
        self,
        information: Float[ndarray, "columns columns"],
        scaled: bool = True,
        prior: bool = True,
    ) -> Float[ndarray, "base base"]:
        own = slice(len(self.base))
        return super()._complete(information[own, own], scaled, prior)

    def _worth_and_slope(
        self, bare: Float[ndarray, "columns columns"], exponent: float
    ) -> tuple[float, Float[ndarray, "columns columns"]]:
        found = [cost_and_slope(own, self.criterion, exponent) for own in self._every(bare)]
        costs = np.array([value for value, _ in found])
        if not np.isfinite(costs).all():
            return float("inf"), np.zeros_like(bare)
        if self.aim == "expected":
            value, weights = float(costs.mean()), np.full(len(costs), 1 / len(costs))
        else:
            soft, weights = soft_maximum(costs * DECADE, exponent)
            value = soft / DECADE
        total = np.zeros_like(bare)
        for weight, places, (_, slope) in zip(weights, self._distinct, found, strict=True):
            own = np.ix_(places, places)
            total[own] += weight * self._of_rows(bare[own], slope)
        return value, total

    def _check_identifiable(self) -> None:
        """Refuse models that have other base parameters."""
        for base in self._bases:
            if not np.array_equal(base.columns, self.base.columns):
                raise NoUsableResult(
                    "a drawn shape changes which parameters can be identified, so that criteria do not "
                    f"compare: {len(base)} base parameters in place of {len(self.base)}"
                )

    def _with_stand(self) -> RobustProblem:
        """The same, towards a posture in which the arm can stand whichever model is true."""
        try:
            posture = find_stand(self._joined, self._full).posture
        except EffortTooSmall as error:
            raise NoUsableResult(
                f"not every drawn model can hold the arm still: joint {error.joint} needs up to "
                f"{error.ratio:.3g} times its effort limit in the easiest posture; know the arm better, or "
                "design without effort limits (--no-torque)"
            ) from error
        return dataclasses.replace(self, stand=posture)


@dataclass(frozen=True)
class _Layout:
    """Where the columns of drawn models stand among those that are evaluated.

    Attributes:
        effects: Drawn anew, one after the other, beyond the nominal model's.
        all_places: (p,) of each drawn model's columns among those of the model with these.
        columns: (c,) of that model, which are evaluated: the nominal base columns first.
        places: (b,) of each drawn model's base columns among the evaluated ones.
    """

    effects: tuple[Effect, ...]
    all_places: list[Int[ndarray, " parameters"]]
    columns: Int[ndarray, " columns"]
    places: list[Int[ndarray, " base"]]

    @classmethod
    def of(cls, problem: RobustProblem) -> _Layout:
        nominal, end = problem.base.columns, len(problem.model.parameters)
        effects: list[Effect] = []
        all_places = []
        for each in problem.scenarios:
            own = np.arange(len(problem.model.parameters))
            for effect, place in _drawn_anew(problem.model, each.model):
                own[place] = end + np.arange(place.stop - place.start)
                end += place.stop - place.start
                effects.append(effect)
            all_places.append(own)
        anew = np.concatenate([own[nominal] for own in all_places])
        columns = np.concatenate([nominal, anew[anew >= len(problem.model.parameters)]])
        where = np.full(end, -1)
        where[columns] = np.arange(len(columns))
        return cls(tuple(effects), all_places, columns, [where[own[nominal]] for own in all_places])


def _drawn_anew(nominal: TorqueModel, drawn: TorqueModel) -> list[tuple[Effect, slice]]:
    """Effects of a drawn model that are not the nominal model's, with their columns."""
    pairs = zip(nominal.effects, with_columns(drawn.effects), strict=True)
    return [(effect, place) for old, (effect, place) in pairs if effect is not old]
