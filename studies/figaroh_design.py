"""Design an excitation with figaroh 1.0.2: run by the interpreter of an environment that has it.

    PYTHON_OF_THAT_ENVIRONMENT studies/figaroh_design.py < REQUEST.json

`studies.compare_figaroh` runs it.

It uses no module of this project, so that both can be installed apart. Objective, spline, limits
and solver are figaroh's own; only its reading of a configuration file is bypassed. Collision is
left out: no geometry is loaded. One segment of five waypoints, two seconds apart, at 20 Hz.
"""

import json
import sys
import time
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, cast

import numpy as np
import pinocchio as pin

try:
    from figaroh.optimal.base_optimal_trajectory import (
        BaseOptimalTrajectory,
        BaseTrajectoryIPOPTProblem,
    )
except ModuleNotFoundError as error:
    # `main` says what is missing.
    if error.name is None or error.name.partition(".")[0] != "figaroh":
        raise
    BaseOptimalTrajectory = BaseTrajectoryIPOPTProblem = cast("Any", object)

TRAJECTORY = {
    "n_wps": 5,
    "freq": 20,
    "t_s": 2.0,
    "soft_lim": 0.0,
    "max_attempts": 1000,
    "segment_attempts": 1,
}


class Trajectory(BaseOptimalTrajectory):
    """figaroh's designer with its two configurations given directly."""

    def __init__(self, robot: pin.RobotWrapper, joints: list[str], iterations: int) -> None:
        self.robot, self.model, self.active_joints = robot, robot.model, joints
        self.logger = __import__("logging").getLogger("figaroh")
        self.trajectory_config = {**TRAJECTORY, "max_iterations": iterations}
        indices = [robot.model.joints[robot.model.getJointId(name)].idx_v for name in joints]
        self.identif_config = {
            "has_friction": True,
            "has_actuator_inertia": False,
            "has_joint_offset": False,
            "is_joint_torques": True,
            "is_external_wrench": False,
            "force_torque": None,
            "act_idxv": indices,
            "active_joints": joints,
            "fv": [0.0] * len(joints),
            "fs": [0.0] * len(joints),
        }
        self.results = {
            "T_F": [], "P_F": [], "V_F": [], "A_F": [],
            "iteration_data": [], "final_regressor_shape": None,
        }  # fmt: skip

    def create_ipopt_problem(self, *arguments: object) -> BaseTrajectoryIPOPTProblem:
        """The problem that the package's own examples derive."""
        return Problem(self, *arguments)


class Problem(BaseTrajectoryIPOPTProblem):
    """figaroh's problem, with its constraint bounds asked for as its feasibility check does."""

    def get_constraint_bounds(self, samples: int | None = None) -> tuple[list, list]:
        """Bounds for all samples."""
        return self.opt_traj.constraint_manager.get_constraint_bounds(samples or self.Ns)


@dataclass(frozen=True)
class Request:
    """What is asked of figaroh.

    Attributes:
        urdf: Robot file.
        out: JSON file to write.
        seed: Of figaroh's random starts.
        iterations: Of IPOPT at most.
        joints: Names of the joints that move.
    """

    urdf: str
    out: str
    seed: int
    iterations: int
    joints: list[str]


def main() -> int:
    """Design, and leave the motion, the objective and the time as JSON; 2 without figaroh."""
    if BaseOptimalTrajectory is object:
        sys.stderr.write(
            f"studies.figaroh_design: {sys.executable} has no package figaroh; run it with the "
            "Python of an environment that has figaroh 1.0.2\n"
        )
        return 2
    given = Request(**json.load(sys.stdin))
    joints = given.joints
    np.random.seed(given.seed)  # noqa: NPY002 - figaroh draws from the global generator
    model = pin.buildModelFromUrdf(given.urdf)
    locked = [i for i in range(1, model.njoints) if model.names[i] not in joints]
    model = pin.buildReducedModel(model, locked, pin.neutral(model))
    robot = pin.RobotWrapper(model, pin.GeometryModel(), pin.GeometryModel())
    robot.geom_model = robot.collision_model
    designer = Trajectory(robot, joints, given.iterations)
    started, wall = time.process_time(), time.perf_counter()
    designer.initialize()
    results = designer.solve(stack_reps=1)
    record = {
        "cpu_s": time.process_time() - started,
        "wall_s": time.perf_counter() - wall,
        "base_parameters": len(designer.idx_b),
        "is_found": bool(results["T_F"]),
        "versions": {name: version(name) for name in ("figaroh", "cyipopt", "pin", "numpy")},
    }
    if results["T_F"]:
        motion = {k: np.asarray(results[k][0]) for k in ("T_F", "P_F", "V_F", "A_F")}
        record |= {k: v.tolist() for k, v in motion.items()}
        details = results["iteration_data"][0]
        record |= {
            "converged": bool(details["converged"]),
            "iterations": len(details["iterations"]),
            "cond_W": float(details["obj_values"][-1]),
        }
    Path(given.out).write_text(json.dumps(record), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
