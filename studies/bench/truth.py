"""What only the judge may know of a data set, and how large the hidden effect is in it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from oed.dynamics.effects import Coulomb, Effect, RigidBody, Viscous
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.simulation import Log
from oed.report.json_file import read_json, write_json
from oed.robot import Robot
from studies.bench.arm import Arm

RANK_TOLERANCE = 1e-9
REVERSAL = 0.0015  # [s] around a change of direction that the oracle leaves out
FLANKS = 5.0  # widths of simulated Coulomb friction, the same
ORACLE_SAMPLES = 20000  # that a fit without noise needs at most, of each recording


@dataclass(frozen=True)
class HiddenTruth:
    """One hidden effect.

    Attributes:
        name: The catalogue's, or "outside".
        form: Key of the form.
        kind: "plain", "other_formula" or "outside".
        joint: From 0; None for the whole arm.
        parameters: Injected values as (value, unit).
        coordinates: Acceptable sets, for what is outside the catalogue.
        in_catalogue: Injected values by a pattern of the catalogue's name of the parameter.
    """

    name: str
    form: str
    kind: str
    joint: int | None
    parameters: dict[str, tuple[float, str]]
    coordinates: tuple[tuple[str, ...], ...]
    in_catalogue: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Truth:
    """The answer to a case.

    Attributes:
        hidden: What is hidden.
        noise: (n,) standard deviation of the torque noise [N m].
        excess: (n,) root mean square of the torque that rigid body, Coulomb and viscous
            friction leave unexplained when fitted to the signals without noise [N m].
        alone: (n,) the same for each of several effects, hidden alone [N m]; empty for one.
    """

    hidden: tuple[HiddenTruth, ...]
    noise: tuple[float, ...]
    excess: tuple[float, ...]
    alone: tuple[tuple[float, ...], ...] = ()

    @property
    def size_in_noise(self) -> float:
        """The largest ratio of excess to noise over the joints."""
        return self._in_noise(self.excess)

    @property
    def smaller_in_noise(self) -> float:
        """The same for the smallest of several effects, each by itself."""
        return min(map(self._in_noise, self.alone or (self.excess,)))

    def _in_noise(self, excess: tuple[float, ...]) -> float:
        return max(e / s for e, s in zip(excess, self.noise, strict=True))

    def write(self, path: Path) -> None:
        """As JSON."""
        write_json(path, self)

    @classmethod
    def read(cls, path: Path) -> Truth:
        """What `write` wrote."""
        raw = read_json(path)
        assert isinstance(raw, dict)  # noqa: S101  # what `write` wrote
        hidden = tuple(
            HiddenTruth(
                name=h["name"],
                form=h["form"],
                kind=h["kind"],
                joint=h["joint"],
                parameters={k: (v[0], v[1]) for k, v in h["parameters"].items()},
                # Truths written before there were such values are still good for the bench.
                in_catalogue=dict(h.get("in_catalogue", {})),
                coordinates=tuple(tuple(c) for c in h["coordinates"]),
            )
            for h in raw["hidden"]
        )
        alone = tuple(tuple(excess) for excess in raw.get("alone", ()))
        return cls(hidden, tuple(raw["noise"]), tuple(raw["excess"]), alone)


def oracle_excess(
    declared: Robot, arm: Arm, logs: list[tuple[Log, Float[ndarray, "rows joints"]]]
) -> Float[ndarray, " joints"]:
    """What the standard model leaves of the torque without noise, with the true motion known.

    Args:
        declared: The robot that the data set declares.
        arm: Whose width of Coulomb friction is used.
        logs: For each estimation recording the log, and (N R, n) its torque without noise,
            at every control period, run after run.
    """
    friction: list[Effect] = []
    for j, width in enumerate(arm.width):
        friction += [Coulomb(j, width), Viscous(j)]
    model = TorqueModel(declared, (RigidBody(declared), *friction))
    rows, torques, joints = [], [], []
    for log, torque in logs:
        kept = slice(None, None, max(1, len(torque) // ORACLE_SAMPLES))
        motion = seen_motion(log, arm)[kept]
        clear = _moves(motion, arm).ravel()
        rows.append(model.regressor(motion)[clear])
        torques.append(torque[kept].ravel()[clear])
        joints.append(np.tile(np.arange(declared.n), len(motion))[clear])
    W, y, joint = (np.concatenate(x) for x in (rows, torques, joints))
    by_joint = [joint == j for j in range(declared.n)]
    weight = 1 / np.array([y[own].std() for own in by_joint])[joint]
    norms = np.maximum(np.linalg.norm(W, axis=0), 1e-12)
    found, *_ = np.linalg.lstsq(weight[:, None] * (W / norms), weight * y, rcond=RANK_TOLERANCE)
    residual = y - W / norms @ found
    return np.array([np.sqrt(np.mean(residual[own] ** 2)) for own in by_joint])


def _moves(motion: Motion, arm: Arm) -> Bool[ndarray, "samples joints"]:
    """Where a joint does not reverse: within that period, a torque is no torque at an instant."""
    within = REVERSAL * np.abs(motion.ddq) + FLANKS * np.array(arm.width)
    return np.abs(motion.dq) > within


def seen_motion(log: Log, arm: Arm) -> Motion:
    """The motion as ideal encoders see it, their lasting errors included, run after run.

    The acceleration at an instant is the mean of those on either side, as the torque is.
    """
    h = float(np.diff(log.t[:2, 0])[0])
    q, dq = log.q, log.dq
    ddq = np.gradient(dq, h, axis=0)
    for change in arm.position_changes:
        error = change(q, h) - q
        rate = np.gradient(error, h, axis=0)
        q, dq, ddq = q + error, dq + rate, ddq + np.gradient(rate, h, axis=0)
    inner = slice(log.lead, log.lead + log.samples)
    n = q.shape[1]
    parts = (x[inner].transpose(2, 0, 1).reshape(-1, n) for x in (q, dq, np.asarray(ddq)))
    return Motion(log.t[inner].T.ravel(), *(np.ascontiguousarray(x) for x in parts))
