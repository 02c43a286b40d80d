"""The arms that carry something in studies of loads and gains: robots, friction and noise of their kind."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from oed.robot import Robot, load_robot
from oed.robot.attached_frame import AttachedFrame, find_frame
from studies.bench.robots import ROBOTS
from studies.data_folders import EXAMPLE_ROBOTS

SCARA = Path(__file__).with_name("scara.toml")  # whose header says what it is after


@dataclass(frozen=True)
class CarryingArm:
    """An arm of the studies.

    Attributes:
        key: Its name.
        load: Gives the robot, as its file has it.
        coulomb: (n,) [N m or N].
        viscous: (n,) [N m s/rad or N s/m].
        noise: (n,) standard deviation of the torque [N m or N].
        highest: Frequency up to which the motion has harmonics [Hz].
    """

    key: str
    load: Callable[[], Robot]
    coulomb: tuple[float, ...]
    viscous: tuple[float, ...]
    noise: tuple[float, ...]
    highest: float = 0.6

    @property
    def robot(self) -> Robot:
        """As its file has it."""
        return _loaded(self.key)

    @property
    def frame(self) -> AttachedFrame:
        """Where it holds a load."""
        return find_frame(self.robot)


def _scara() -> Robot:
    robot = load_robot(SCARA)
    acceleration = np.array([20.0, 25.0, 10.0, 60.0])  # [rad/s^2, m/s^2]
    bounds = np.stack([-acceleration, acceleration], axis=1)
    return robot.with_limits(robot.limits.with_(acceleration=bounds))


def _of_bench(key: str) -> Callable[[], Robot]:
    def load() -> Robot:
        with tempfile.TemporaryDirectory() as folder:
            return ROBOTS[key].declared(Path(folder))

    return load


def _ur10() -> Robot:
    robot = load_robot(EXAMPLE_ROBOTS / "ur_description/urdf/ur10_robot.urdf")
    n = robot.n
    return robot.with_limits(
        robot.limits.with_(
            position=np.array([[-2.8, 2.8], [-2.6, -0.5], [-2.2, 2.2], *[[-2.6, 2.6]] * 3]),
            velocity=np.tile([-2.0, 2.0], (n, 1)),
            acceleration=np.tile([-5.0, 5.0], (n, 1)),
        )
    )


def _as_of_bench(key: str) -> CarryingArm:
    bench = ROBOTS[key]
    return CarryingArm(
        key, _of_bench(key), bench.coulomb, bench.viscous, bench.noise, bench.highest
    )


ARMS = {
    arm.key: arm
    for arm in (
        _as_of_bench("ur5"),
        _as_of_bench("panda"),
        CarryingArm(
            "scara",
            _scara,
            coulomb=(3.0, 2.0, 12.0, 0.25),
            viscous=(2.0, 1.2, 40.0, 0.08),
            noise=(0.5, 0.3, 1.5, 0.03),
            highest=1.2,
        ),
        CarryingArm(
            "ur10",
            _ur10,
            coulomb=(12.0, 14.0, 9.0, 2.2, 2.0, 1.7),
            viscous=(15.0, 17.0, 11.0, 2.4, 2.1, 1.8),
            noise=(1.0, 1.2, 0.8, 0.2, 0.17, 0.15),
        ),
    )
}


@cache
def _loaded(key: str) -> Robot:
    return ARMS[key].load()
