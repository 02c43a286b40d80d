"""The arms of the bench: what is declared of them, and what they truly are."""

from __future__ import annotations

import dataclasses
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from oed.robot import JointLimits, Robot, load_robot
from oed.robot.builtin import IMI_COULOMB, IMI_VISCOUS
from oed.robot.inertia import parameters_from_pseudo_inertia
from studies.bench.arm import PERIOD, Arm, least_inertia
from studies.data_folders import EXAMPLE_ROBOTS

LINK_SPREAD = 0.05  # relative scatter of each link's true mass about the declared one
FRICTION_SPREAD = 0.15
# So many decay times of Coulomb friction's flank fit into one Runge-Kutta step of the arm.
FLANK = 0.7


@dataclass(frozen=True)
class BenchRobot:
    """An arm of the bench.

    Attributes:
        key: Its name in the cases.
        load: Gives the declared robot; a file that has to be made goes into the given folder.
        mass: The typical true link parameters given the declared ones.
        coulomb: (n,) typical Coulomb friction [N m].
        viscous: (n,) typical viscous friction [N m s/rad].
        noise: (n,) standard deviation of the torque noise [N m].
        highest: Frequency up to which the motion has harmonics [Hz].
        repetitions: Of every recording that has repetitions.
        period: Of their motion [s].
        single: Length of a recording without repetitions [s].
        decimation: Control periods a logged sample.
        substeps: Runge-Kutta steps a control period. Light joints with dry friction need many, or
            a friction that turns round at speeds that a log shows.
    """

    key: str
    load: Callable[[Path], Robot]
    mass: Callable[[Robot], Float[ndarray, " standard"]]
    coulomb: tuple[float, ...]
    viscous: tuple[float, ...]
    noise: tuple[float, ...]
    highest: float
    repetitions: int = 6
    period: float = 10.0
    single: float = 40.0
    decimation: int = 4
    substeps: int = 4

    def declared(self, folder: Path) -> Robot:
        """What the data set says of the arm."""
        return self.load(folder)

    def arm(self, declared: Robot, rng: np.random.Generator) -> Arm:
        """A true arm with nothing hidden: links and friction scatter about the typical ones."""
        n = declared.n
        scale = np.repeat(1 + LINK_SPREAD * rng.standard_normal(n), 10)
        robot = declared.with_parameters(self.mass(declared) * scale)
        factors = np.exp(FRICTION_SPREAD * rng.standard_normal((2, n)))
        coulomb = np.array(self.coulomb) * factors[0]
        least, _ = least_inertia(robot, rng)
        width = coulomb * PERIOD / (self.substeps * FLANK * least)
        return Arm(
            robot,
            tuple(coulomb.tolist()),
            tuple((np.array(self.viscous) * factors[1]).tolist()),
            tuple(width.tolist()),
            substeps=self.substeps,
        )


def _scara(folder: Path) -> Robot:
    del folder
    return load_robot("builtin:imi_scara")


def _vertical(folder: Path) -> Robot:
    """The same two joints on level axes, with room to swing."""
    del folder
    limits = JointLimits.symmetric((2.6, 2.4), (5.0, 6.0), (9.0, 12.0))
    return load_robot("builtin:imi_scara", gravity=(0.0, -9.81, 0.0)).with_limits(limits)


def _ur5(folder: Path) -> Robot:
    del folder
    robot = load_robot(_example("ur_description/urdf/ur5_robot.urdf"))
    n = robot.n
    return robot.with_limits(
        robot.limits.with_(
            position=np.array([[-2.8, 2.8], [-2.6, -0.5], [-2.2, 2.2], *[[-2.6, 2.6]] * 3]),
            velocity=np.tile([-2.8, 2.8], (n, 1)),
            acceleration=np.tile([-6.0, 6.0], (n, 1)),
        )
    )


def _panda(folder: Path) -> Robot:
    """The arm with its hand closed for good: a data set has no word for locked joints."""
    tree = ET.parse(_example("panda_description/urdf/panda.urdf"))  # noqa: S314  # a package's own file
    for joint in tree.getroot().iter("joint"):
        if joint.get("type") == "prismatic":
            joint.set("type", "fixed")
            for child in [c for c in joint if c.tag in ("axis", "limit", "mimic", "dynamics")]:
                joint.remove(child)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "panda.urdf"
    tree.write(path)
    robot = load_robot(path)
    return robot.with_limits(robot.limits.with_(acceleration=np.tile([-7.0, 7.0], (robot.n, 1))))


def _example(name: str) -> Path:
    return EXAMPLE_ROBOTS / name


def _as_declared(robot: Robot) -> Float[ndarray, " standard"]:
    return robot.parameters


def _light_links(robot: Robot) -> Float[ndarray, " standard"]:
    """Two slender links of 6 and 3 kg."""
    del robot
    return np.concatenate([_rod(6.0, 0.36, 0.05), _rod(3.0, 0.30, 0.04)])


def _with_tool(robot: Robot) -> Float[ndarray, " standard"]:
    """A tool of 2.5 kg that sticks out sideways on the last link."""
    rows = robot.parameters.reshape(-1, 10).copy()
    rows[-1] += _body(2.5, np.array([0.06, 0.02, 0.08]), 0.012)
    return rows.ravel()


def _rod(mass: float, length: float, radius: float) -> Float[ndarray, "10"]:
    return _body(mass, np.array([length / 2, 0.0, 0.0]), mass * radius**2, length)


def _body(
    mass: float, centre: Float[ndarray, "3"], inertia: float, length: float = 0.0
) -> Float[ndarray, "10"]:
    """Mass, its centre, an even inertia about it, and a stretch along x."""
    spread = inertia / 2 * np.eye(3)
    spread[0, 0] += mass * length**2 / 12
    pseudo = np.zeros((4, 4))
    pseudo[:3, :3] = spread + mass * np.outer(centre, centre)
    pseudo[:3, 3] = pseudo[3, :3] = mass * centre
    pseudo[3, 3] = mass
    return parameters_from_pseudo_inertia(pseudo)


_SCARA = BenchRobot(
    "scara", _scara, _as_declared, IMI_COULOMB, IMI_VISCOUS, noise=(0.5, 0.1), highest=0.7
)
ROBOTS = {
    robot.key: robot
    for robot in (
        _SCARA,
        dataclasses.replace(
            _SCARA,
            key="vertical",
            load=_vertical,
            mass=_light_links,
            coulomb=(3.0, 1.2),
            viscous=(1.6, 0.6),
            noise=(0.4, 0.12),
            highest=0.8,
        ),
        BenchRobot(
            "ur5",
            _ur5,
            _with_tool,
            coulomb=(9.0, 10.0, 6.0, 1.6, 1.5, 1.2),
            viscous=(11.0, 12.0, 8.0, 1.8, 1.6, 1.3),
            noise=(0.8, 0.9, 0.6, 0.15, 0.12, 0.1),
            highest=0.6,
            repetitions=4,
            period=15.0,
            single=60.0,
            decimation=5,
            substeps=8,
        ),
        BenchRobot(
            "panda",
            _panda,
            _with_tool,
            coulomb=(0.8, 0.9, 0.8, 1.2, 0.6, 0.5, 0.5),
            viscous=(1.0, 1.0, 0.8, 1.0, 0.4, 0.3, 0.3),
            noise=(0.08, 0.12, 0.08, 0.1, 0.05, 0.05, 0.04),
            highest=0.6,
            repetitions=4,
            period=15.0,
            single=60.0,
            decimation=5,
            substeps=8,
        ),
    )
}
