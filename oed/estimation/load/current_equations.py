"""Currents of an arm without and with known loads, linear about an estimate.

    i_j = u_j [(H beta)_j + (L phi)_j + mu_j |r_j| s_j],      u_j = 1 / k_j,

one beta for all joints, k_j the joint's N m per A. What is noisy, the current, stands alone on the left, and
the right is exact in the motion: least squares are consistent. Written the other way round, k_j i_j = ...,
the noise would stand among the regressors (Gautier and Briot 2014, "Global identification of joint drive
gains and dynamic parameters of robots", who therefore take total least squares), and bias k_j.
A known mass fixes the common factor of all k_j; what the joints share fixes their ratios.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.estimation.load.loaded_model import ENTRIES, LoadedModel
from oed.estimation.load.torque_equations import TorqueEquations
from oed.experiment.preparation.processed import ProcessedRecording


@dataclass(frozen=True)
class KnownLoad:
    """What is known of a load.

    Attributes:
        mass: [kg]; None where nothing is.
        centre: (3,) of mass, in the frame that holds it [m]; None where it is not known.
    """

    mass: float | None = None
    centre: Float[ndarray, "3"] | None = None

    def fixed(self, model: LoadedModel) -> dict[int, float]:
        """Values of those of the ten parameters about the joint's body frame that are known."""
        if self.mass is None:
            return {}
        if self.centre is None:
            return {0: self.mass}
        moment = self.mass * (model.frame.R_JF @ self.centre + model.frame.p_JF)
        return {0: self.mass, **{1 + axis: float(moment[axis]) for axis in range(3)}}


@dataclass(frozen=True)
class CurrentEquations:
    """Recordings of one arm, bare and with loads; x = (beta, all phi, all changes of friction, mu, log u).

    Attributes:
        bare: Without a load; None where there is no such recording.
        loaded: With a load each.
        loads: What is known of these.
    """

    bare: TorqueEquations | None
    loaded: tuple[TorqueEquations, ...]
    loads: tuple[KnownLoad, ...]

    @classmethod
    def of(
        cls,
        model: LoadedModel,
        bare: Sequence[ProcessedRecording],
        loaded: Sequence[Sequence[ProcessedRecording]],
        loads: Sequence[KnownLoad],
    ) -> CurrentEquations:
        """Evaluate a bare arm's model along recordings of it, without and with loads."""
        carrying = model.loaded()
        return cls(
            TorqueEquations.of(model, bare) if bare else None,
            tuple(TorqueEquations.of(carrying, recordings) for recordings in loaded),
            tuple(loads),
        )

    @property
    def sets(self) -> tuple[TorqueEquations, ...]:
        """Those of every folder, the bare arm first."""
        return (*((self.bare,) if self.bare else ()), *self.loaded)

    @property
    def model(self) -> LoadedModel:
        """Of the bare arm."""
        model = self.sets[0].model
        return LoadedModel(model.arm, model.base, model.frame, (), model.has_load_friction)

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return self.model.arm.robot.n

    @property
    def current(self) -> Float[ndarray, "samples joints"]:
        """Measured, one recording after another [A]."""
        return np.concatenate([equations.torque for equations in self.sets])

    @property
    def segments(self) -> tuple[int, ...]:
        """Samples of each recording."""
        return tuple(n for equations in self.sets for n in equations.segments)

    @property
    def has_scale(self) -> bool:
        """Whether a known mass fixes the common factor of all gains."""
        return any(load.mass is not None for load in self.loads)

    @cached_property
    def free(self) -> tuple[tuple[int, ...], ...]:
        """Of each load, which of its kept parameters are not known."""
        return tuple(
            tuple(k for k in equations.model.kept if k not in load.fixed(equations.model))
            for equations, load in zip(self.loaded, self.loads, strict=True)
        )

    @cached_property
    def friction(self) -> tuple[int, ...]:
        """Which of beta may differ from one folder to the next."""
        return tuple(np.flatnonzero(self.model.is_friction[: len(self.model.base)]).tolist())

    @cached_property
    def places(self) -> dict[str, slice]:
        """Where each part of x stands."""
        changes = len(self.friction) * (len(self.sets) - 1)
        loads = sum(len(free) for free in self.free)
        sizes = {"beta": len(self.model.base), "phi": loads, "change": changes}
        sizes |= {"mu": self.joints, "log_u": self.joints}
        ends = np.cumsum(list(sizes.values())).tolist()
        return {
            name: slice(end - size, end)
            for (name, size), end in zip(sizes.items(), ends, strict=True)
        }

    @property
    def size(self) -> int:
        """Of x."""
        return self.places["log_u"].stop

    def body(self, x: Float[ndarray, " x"], load: int) -> Float[ndarray, "10"]:
        """Parameters of a load about its joint's body frame, zero where no torque depends on them."""
        full = np.zeros(ENTRIES)
        for k, value in self.loads[load].fixed(self.loaded[load].model).items():
            full[k] = value
        full[list(self.free[load])] = x[self._phi(load)]
        return full

    def modelled(self, at: Float[ndarray, " x"]) -> Float[ndarray, "samples joints"]:
        """Current of an estimate [A]."""
        mu, u = at[self.places["mu"]], np.exp(at[self.places["log_u"]])
        pieces = []
        for number, equations in enumerate(self.sets):
            to_own, known = self._own(number)
            pieces.append(equations.modelled(np.append(to_own @ at + known, mu)))
        return np.concatenate(pieces) * u

    def linearised(
        self, at: Float[ndarray, " x"]
    ) -> tuple[Float[ndarray, "rows x"], Float[ndarray, "samples joints"]]:
        """Regressor and current of the linear problem about an estimate.

        The solution of these equations is the next estimate, not its step.
        """
        pieces = [self._set(number, at) for number in range(len(self.sets))]
        rows = np.concatenate([rows for rows, _ in pieces])
        return rows.reshape(-1, self.size), np.concatenate([right for _, right in pieces])

    def _phi(self, load: int) -> slice:
        start = self.places["phi"].start + sum(len(free) for free in self.free[:load])
        return slice(start, start + len(self.free[load]))

    def _set(self, number: int, at: Float[ndarray, " x"]) -> tuple[ndarray, ndarray]:
        equations, n = self.sets[number], self.joints
        to_own, known = self._own(number)
        mu, u = at[self.places["mu"]], np.exp(at[self.places["log_u"]])
        own = to_own @ at + known
        joined, _ = equations.linearised(np.append(own, mu))
        joined = joined.reshape(-1, n, joined.shape[1]) * u[:, None]
        by_own, by_mu = joined[:, :, :-n], joined[:, :, -n:]
        modelled = by_own @ own
        rows = by_own @ to_own
        rows[:, :, self.places["mu"]] = by_mu
        rows[:, :, self.places["log_u"]] = modelled[:, :, None] * np.eye(n)
        right = equations.torque - by_own @ known + by_mu @ mu
        right = right + modelled * at[self.places["log_u"]]
        return rows, right

    def _own(self, number: int) -> tuple[Float[ndarray, "own x"], Float[ndarray, " own"]]:
        """A folder's own beta and phi as a linear function of x, and what is known of them."""
        equations, base = self.sets[number], len(self.model.base)
        to_own = np.zeros((base + len(equations.model.kept), self.size))
        known = np.zeros(len(to_own))
        to_own[:base, self.places["beta"]] = np.eye(base)
        if number > 0:
            count = len(self.friction)
            start = self.places["change"].start + count * (number - 1)
            to_own[list(self.friction), range(start, start + count)] = 1.0
        if not equations.model.kept:
            return to_own, known
        load = number - (self.bare is not None)
        place = dict(zip(self.free[load], range(*self._phi(load).indices(self.size)), strict=True))
        fixed = self.loads[load].fixed(equations.model)
        for row, k in enumerate(equations.model.kept, start=base):
            if k in place:
                to_own[row, place[k]] = 1.0
            else:
                known[row] = fixed[k]
        return to_own, known
