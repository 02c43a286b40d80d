"""Recordings of the paper's arm in simulation, with an effect that its model does not declare."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence

import numpy as np

from oed.dynamics.effects import State
from oed.dynamics.motion import Motion
from oed.dynamics.scalars import Scalar
from oed.experiment.dataset import DataSet
from oed.experiment.disturbance import Disturbance
from oed.experiment.friction_memory import BristleFriction
from oed.experiment.imi_laboratory import ImiLaboratory
from oed.experiment.plant import TruePlant
from oed.experiment.recording import Recording, Role
from oed.experiment.setup import Setup
from oed.experiment.simulation import simulate
from oed.robot.builtin import IMI_COULOMB, imi_scara

HIDDEN = ("cable", "stribeck", "none")
STATIC_RISE = 0.6  # of the Coulomb friction of joint 1, towards standstill
STRIBECK_SPEED = 0.15  # [rad/s]
CABLE_STIFFNESS = 1.2  # [N m/rad] of a cable that pulls joint 2 back
CABLE_REST = 0.3  # [rad]
# Torque that reaches the joints beside the commanded one, and the logger's own noise.
DISTURBANCE = Disturbance((0.3, 0.08), (30.0, 30.0))  # [N m], [rad/s]
LOGGED = 4  # one sample in that many is written: 250 Hz of the controller's 1 kHz


def record_imi(
    motions: Iterable[tuple[str, Role, Motion]],
    rng: np.random.Generator,
    *,
    hidden: str,
    repetitions: int,
    source: str,
) -> DataSet:
    """Recordings of the paper's arm that follows motions under the paper's controller.

    Args:
        motions: Name, role and one period each, sampled at `control_period`.
        rng: Of disturbances and sensor noise.
        hidden: What the data set does not declare: one of `HIDDEN`.
        repetitions: Of each motion.
        source: Written into the data set.
    """
    laboratory = ImiLaboratory()
    setup = Setup(
        _plant(laboratory, hidden),
        laboratory.controller(),
        laboratory.setup("plain", laboratory.controller(), DISTURBANCE).sensors,
        DISTURBANCE,
        lead_in=laboratory.settling,
    )
    recordings = tuple(
        _thinned(
            simulate(
                setup, motion, rng, repetitions=repetitions, periodic=True, name=name, role=role
            )
        )
        for name, role, motion in motions
    )
    return DataSet(
        name="imi-scara-simulated",
        source=source,
        licence="BSD-3-Clause",
        robot=imi_scara(),
        torque="commanded",
        recordings=recordings,
    )


def control_period() -> float:
    """Sample time of the controller [s]."""
    return ImiLaboratory().controller().period


def _plant(laboratory: ImiLaboratory, hidden: str) -> TruePlant:
    plant = laboratory.plant("plain")
    if hidden == "cable":
        return dataclasses.replace(plant, extra=(*plant.extra, _cable))
    if hidden == "stribeck":
        rising = BristleFriction(
            joint=0,
            coulomb=IMI_COULOMB[0],
            deflection=laboratory.presliding,
            static_rise=STATIC_RISE * IMI_COULOMB[0],
            stribeck_speed=STRIBECK_SPEED,
        )
        return dataclasses.replace(plant, memory=(rising, *plant.memory[1:]))
    return plant


def _cable(state: State, load: Sequence[Scalar]) -> dict[int, Scalar]:  # noqa: ARG001  # any load
    return {1: CABLE_STIFFNESS * (state.q[1] - CABLE_REST)}


def _thinned(recording: Recording) -> Recording:
    kept = slice(None, None, LOGGED)
    repetition = recording.repetition
    return dataclasses.replace(
        recording,
        t=recording.t[kept],
        q=recording.q[kept],
        tau=recording.tau[kept],
        dq=None,
        repetition=None if repetition is None else repetition[kept],
    )
