"""How fast is the design criterion? Value and gradient of J_d against Pinocchio's regressor.

Both at the same instants, single-threaded, in turn within one run, so that a busy machine slows
both alike.

    OMP_NUM_THREADS=1 python -m studies.speed --robot FILE [--instants 1000] [--out results/speed]
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pinocchio

from oed.commands.options import Count, Seed, parse
from oed.design.criteria import cost_and_slope
from oed.design.fast_information import FastInformation
from oed.dynamics.compiled import CompiledRegressor, compile_regressor
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion, random_motion
from oed.dynamics.torque_model import TorqueModel
from oed.process_end import leave
from oed.report.json_file import write_json
from oed.report.provenance import Provenance
from oed.robot import arm_joints, load_robot
from studies.data_folders import PANDA
from studies.study_options import StudyOptions

SIGN_WIDTH = 0.02  # [rad/s]


@dataclass(frozen=True)
class Config:
    """What is timed.

    Attributes:
        robot: URDF.
        instants: Number N.
        repetitions: Of each, alternating.
        seed: Of the states.
    """

    robot: str
    instants: int = 1000
    repetitions: int = 15
    seed: int = 0


@dataclass(frozen=True)
class Result:
    """Medians of time [ms], and of the ratio within each repetition.

    Attributes:
        joints: Number of joints.
        base: Number of base parameters, friction included.
        entries: Structurally nonzero entries of the base regressor.
        is_native: Whether machine code ran.
        build_s: To build and, the first time, compile the expressions [s].
        value_ms: Lambda alone.
        gradient_ms: J_d and its gradient by q, dq and ddq.
        interpreted_ms: The same on CasADi's virtual machine.
        pinocchio_ms: computeJointTorqueRegressor at every instant.
        ratio: gradient_ms / pinocchio_ms.
    """

    joints: int
    base: int
    entries: int
    is_native: bool
    build_s: float
    value_ms: float
    gradient_ms: float
    interpreted_ms: float
    pinocchio_ms: float
    ratio: float


def run(config: Config) -> Result:
    """Time all four."""
    names = arm_joints(config.robot)
    robot = load_robot(config.robot, joints=names)
    model = TorqueModel.standard(robot)
    base = base_parameters(model)
    motion = random_motion(robot, config.instants, np.random.default_rng(config.seed))
    started = time.perf_counter()
    regressor = compile_regressor(model, base)
    build_s = time.perf_counter() - started
    fast = FastInformation(regressor)
    slow = FastInformation(compile_regressor(model, base, native=False))
    tasks = {
        "value": lambda: fast.information(motion, SIGN_WIDTH),
        "gradient": lambda: value_and_gradient(fast, motion),
        "interpreted": lambda: value_and_gradient(slow, motion),
        "pinocchio": pinocchio_task(config.robot, names, motion),
    }
    times = alternate(tasks, config.repetitions)
    medians = {name: float(np.median(values) * 1e3) for name, values in times.items()}
    return Result(
        joints=robot.n,
        base=len(base),
        entries=entries_of(regressor),
        is_native=regressor.is_native,
        build_s=build_s,
        **{f"{name}_ms": value for name, value in medians.items()},
        ratio=float(np.median(times["gradient"] / times["pinocchio"])),
    )


def value_and_gradient(fast: FastInformation, motion: Motion) -> tuple:
    """J_d with its gradient by q, dq and ddq at every instant."""
    information, entries = fast.information_and_entries(motion, SIGN_WIDTH)
    value, slope = cost_and_slope(information, "J_d")
    return value, fast.regressor.pull_back(motion, fast.adjoint(entries, slope), SIGN_WIDTH)


def pinocchio_task(urdf: str, names: tuple[str, ...], motion: Motion) -> Callable[[], None]:
    """Pinocchio's regressor at every instant, of the same joints."""
    full = pinocchio.buildModelFromUrdf(urdf)
    locked = [full.getJointId(name) for name in full.names[1:] if name not in names]
    model = pinocchio.buildReducedModel(full, locked, pinocchio.neutral(full))
    data = model.createData()
    states = list(zip(motion.q, motion.dq, motion.ddq, strict=True))

    def task() -> None:
        for q, dq, ddq in states:
            pinocchio.computeJointTorqueRegressor(model, data, q, dq, ddq)

    return task


def alternate(tasks: dict[str, Callable[[], object]], repetitions: int) -> dict[str, np.ndarray]:
    """CPU time of each task in every repetition [s], the tasks in turn."""
    times: dict[str, list[float]] = {name: [] for name in tasks}
    for _ in range(repetitions):
        for name, task in tasks.items():
            started = time.process_time()
            task()
            times[name].append(time.process_time() - started)
    return {name: np.array(values) for name, values in times.items()}


def entries_of(regressor: CompiledRegressor) -> int:
    """Number of structurally nonzero entries."""
    return len(regressor.entry_joint)


def write(result: Result, config: Config, out: Path) -> None:
    """Write `speed.json` and the provenance."""
    write_json(out / "speed.json", result)
    Provenance.collect(config, seed=config.seed).write(out / "provenance.json")


@dataclass(frozen=True)
class Options(StudyOptions):
    """What do value and gradient of a criterion cost, beside Pinocchio's regressor?

    Attributes:
        robot: URDF file.
        instants: Number N.
        seed: Of the states.
    """

    study: ClassVar[str] = "speed"
    names: ClassVar[tuple[str, ...]] = ("speed.json", "provenance.json")

    robot: str = str(PANDA)
    instants: Count = Config.instants
    seed: Seed = Config.seed


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    options = parse(Options, prog="python -m studies.speed", arguments=arguments)
    config = Config(
        robot=options.robot,
        instants=50 if options.smoke else options.instants,
        repetitions=2 if options.smoke else Config.repetitions,
        seed=options.seed,
    )
    with options.held([config.robot]) as results:
        result = run(config)
        with results.replaced() as new:
            write(result, config, new)
    print(
        f"{result.joints} joints, {result.base} base parameters, {config.instants} instants: "
        f"Lambda {result.value_ms:.1f} ms, J_d with gradient {result.gradient_ms:.1f} ms "
        f"({'machine code' if result.is_native else 'virtual machine'}; virtual machine "
        f"{result.interpreted_ms:.1f} ms), Pinocchio's regressor alone {result.pinocchio_ms:.1f} "
        f"ms: {result.ratio:.2f} times"
    )


if __name__ == "__main__":
    leave(main, "studies.speed")
