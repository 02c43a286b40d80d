"""How many experiments does it take to find an effect that the model was not told of?

    python -m studies.loop --out DIR [--hidden NAME] [--rounds R] [--smoke] [--seed N]

A simulated arm hides an effect. Each round designs a motion, runs it, estimates and diagnoses;
what is doubtful decides the next design. The loop ends when the data explain themselves, when two
motions running show nothing, or when the budget is spent; rounds.csv says what each round bought.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from oed.commands.options import Count, Seed, parse
from oed.design.limits import fill
from oed.design.problem import DesignProblem
from oed.design.trajectories import FourierClass
from oed.diagnosis.diagnose import Diagnosis, diagnose
from oed.diagnosis.discrimination.next_motion import design_next
from oed.dynamics.effects import Effect
from oed.dynamics.effects.position import JointSpring, PositionFriction
from oed.dynamics.effects.stribeck import Stribeck
from oed.dynamics.identifiability import base_parameters
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.dataset import DataSet
from oed.experiment.imi_laboratory import ImiLaboratory
from oed.experiment.recording import HELD_OUT, Recording, Role
from oed.experiment.simulation import Setup, simulate
from oed.process_end import leave
from oed.report.output_folder import check_output_folder
from oed.report.provenance import Provenance
from oed.report.result_folder import ResultFiles
from oed.report.table import Row, text_table, write_csv

FILES = ResultFiles("loop", ("rounds.csv", "provenance.json"), goes_on=True)
PERIOD = 10.0  # [s] of every motion
REPETITIONS = 4
STEP = 0.001  # [s] of the controller
DESIGNS = 48  # random motions of which the most informative is run
# What may be hidden: an effect of the plant and the sizes of its parameters.
HIDDEN: dict[str, tuple[Callable[[], Effect], tuple[float, ...]]] = {
    "stribeck": (lambda: Stribeck(0, 0.1, 2.0), (0.9,)),
    "position_dependent_friction": (lambda: PositionFriction(1, (2.0,)), (0.4, 0.2)),
    "joint_spring": (lambda: JointSpring(1), (0.8, 0.2)),
}


@dataclass(frozen=True)
class Config:
    """What to hide, and how long to look.

    Attributes:
        out: Folder for the table.
        hidden: Key of `HIDDEN`, or "nothing".
        rounds: Most experiments.
        smoke: Few designs.
        seed: Of everything random.
    """

    out: Path
    hidden: str = "stribeck"
    rounds: Count = 4
    smoke: bool = False
    seed: Seed = 0

    def __post_init__(self) -> None:
        check_output_folder(self.out)
        if self.hidden not in (*HIDDEN, "nothing"):
            known = ", ".join((*sorted(HIDDEN), "nothing"))
            raise ValueError(f"--hidden {self.hidden}: there are {known}")


def run(config: Config) -> list[Row]:
    """Design, run, estimate, diagnose, redesign; one row a round."""
    rng = np.random.default_rng(config.seed)
    setup = laboratory(config.hidden)
    model = TorqueModel.standard(setup.plant.robot)
    count = 6 if config.smoke else DESIGNS
    held = [_record(setup, informative_motion(model, rng, 1), rng, role) for role in HELD_OUT]
    recordings: list[Recording] = []
    rows: list[Row] = []
    motion, purpose = informative_motion(model, rng, count), "J_d: all base parameters"
    for number in range(1, config.rounds + 1):
        recordings.append(_record(setup, motion, rng, "estimation", number))
        robot = setup.plant.robot
        dataset = DataSet(
            "loop", "simulation", "none", robot, "measured", recordings=(*recordings, *held)
        )
        found = diagnose(dataset, model, seed=config.seed)
        rows.append(_row(number, purpose, found))
        _say(text_table(rows[-1:]))
        # What one motion does not show, another may.
        again = number > 1 and rows[-2]["verdict"] == found.verdict
        if found.verdict == "explained" or (found.verdict == "nothing found" and again):
            break
        motion, purpose = _next_motion(found, model, rng, count)
    return rows


def laboratory(hidden: str) -> Setup:
    """The virtual IMI laboratory, its arm with one more effect.

    Raises:
        ValueError: If nothing of that name can be hidden.
    """
    lab = ImiLaboratory()
    setup = lab.setup("plain", lab.controller(), lab.quiet())
    if hidden == "nothing":
        return setup
    if hidden not in HIDDEN:
        raise ValueError(f"cannot hide {hidden!r}; there are {sorted(HIDDEN)} and 'nothing'")
    build, sizes = HIDDEN[hidden]
    plant = dataclasses.replace(
        setup.plant,
        effects=(*setup.plant.effects, build()),
        parameters=(*setup.plant.parameters, *sizes),
    )
    return dataclasses.replace(setup, plant=plant)


def informative_motion(model: TorqueModel, rng: np.random.Generator, count: int) -> Motion:
    """The most informative (J_d) of some random motions within the limits."""
    cycle = FourierClass(PERIOD, model.robot.limits, harmonics=5)
    problem = DesignProblem(
        model=model,
        base=base_parameters(model),
        trajectory=cycle,
        limits=model.robot.limits,
        instants=np.linspace(0.0, PERIOD, 200, endpoint=False),
    )
    starts = [fill(cycle, cycle.draw(rng), model.robot.limits) for _ in range(count)]
    best = min(starts, key=problem.cost) if count > 1 else starts[0]
    return cycle.motion(best, np.arange(round(PERIOD / STEP)) * STEP)


def write(rows: list[Row], config: Config, out: Path) -> None:
    """The table of rounds and its provenance."""
    write_csv(out / "rounds.csv", rows)
    Provenance.collect(config, seed=config.seed).write(out / "provenance.json")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line."""
    config = parse(Config, prog="python -m studies.loop", arguments=arguments)
    with FILES.in_folder(config.out) as results:
        rows = run(config)
        with results.replaced() as new:
            write(rows, config, new)
    _say(text_table(rows))
    return 0


def _next_motion(
    found: Diagnosis, model: TorqueModel, rng: np.random.Generator, count: int
) -> tuple[Motion, str]:
    """Where a name is open the motion that tells what it is; else one that informs of all."""
    following = design_next(found, rng, candidates=count)
    if following is None:
        return informative_motion(model, rng, count), "J_d: another motion"
    return _whole_period(following.motion), "; ".join(following.pairs)


def _whole_period(motion: Motion) -> Motion:
    """Brought to the control period, as a period that closes."""
    samples = round(PERIOD / STEP)
    t = np.arange(samples) * STEP
    period = motion.t[-1] - motion.t[0] + (motion.t[1] - motion.t[0])
    pace = period / PERIOD
    share = t * pace + motion.t[0]
    q, dq, ddq = (
        np.stack([np.interp(share, motion.t, column, period=period) for column in x.T], axis=1)
        for x in (motion.q, motion.dq, motion.ddq)
    )
    return Motion(t, q, dq * pace, ddq * pace**2)


def _record(
    setup: Setup, motion: Motion, rng: np.random.Generator, role: Role, number: int = 0
) -> Recording:
    return simulate(
        setup,
        motion,
        rng,
        repetitions=REPETITIONS,
        periodic=True,
        name=f"{role}_{number}",
        role=role,
    )


def _row(number: int, purpose: str, found: Diagnosis) -> Row:
    errors = {
        e.role: (float(np.linalg.norm(e.before)), float(np.linalg.norm(e.after)))
        for e in found.errors
    }
    return {
        "round": number,
        "designed for": purpose,
        "verdict": found.verdict,
        "effects": ", ".join(_label(e.name, e.joint) for e in found.effects),
        "least probability of a name": min((e.probability for e in found.effects), default=""),
        "validation before [N m]": errors["validation"][0],
        "validation after [N m]": errors["validation"][1],
        "test before [N m]": errors["test"][0],
        "test after [N m]": errors["test"][1],
        "noise floor [N m]": float(np.linalg.norm(found.noise_floor)),
    }


def _label(name: str, joint: int | None) -> str:
    return name if joint is None else f"{name}_{joint + 1}"


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    leave(main, "studies.loop")
