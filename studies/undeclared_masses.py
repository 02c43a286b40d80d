"""Where does what a model lacks end up: in its masses, or beside them?

    python -m studies.undeclared_masses [--smoke] [--out results/undeclared_masses] [--seeds 62 63]
                                       [--budget S]

A UR5 with bodies unlike those of its file, a spring at its second joint and constant torques at four
joints, none of which is declared, records four motions. `oed feasible` alone explains what is missing
by mass; `oed calibrate` looks for it first. Both start from the same file and pull to its inertials.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
import tyro
from jaxtyping import Float
from numpy import ndarray

from oed.commands import calibrate, feasible
from oed.commands.configurations import Calibrate, Feasible
from oed.commands.options import parse
from oed.commands.rollouts import BASE_OF_BODIES
from oed.dynamics.effects import TorqueOffset
from oed.dynamics.effects.position import JointSpring
from oed.dynamics.models import build_model
from oed.dynamics.motion import Motion
from oed.errors import OedError
from oed.experiment.dataset import DataSet
from oed.experiment.write_dataset import write_dataset
from oed.export.model_file import NAME, load_model
from oed.process_end import leave
from oed.report.json_file import read_json, write_atomically
from oed.report.provenance import Provenance
from oed.report.table import Row, markdown_table, write_csv
from oed.robot import Robot, load_robot
from studies.data_folders import EXAMPLE_ROBOTS
from studies.study_options import StudyOptions

UR5 = "ur_description/urdf/ur5_robot.urdf"
ROLES = ("estimation", "estimation", "validation", "test")
HARMONICS = (0.1, 0.2, 0.3, 0.4, 0.5)  # [Hz]


@dataclass(frozen=True)
class Config:
    """What is simulated.

    Attributes:
        seeds: Of bodies, motions and noise, one arm each.
        seconds: Of a recording.
        rate: [Hz], of a UR's interface.
        spread: Factors of the file's bodies.
        spring: At joint 2 [N m/rad].
        offsets: At joints 1, 2, 3 and 5 [N m].
        noise: (n,) standard deviation of the torque [N m].
        candidates: Effects that the diagnosis may name; the whole catalogue if empty.
        budget: CPU time of each search [s]; as long as it takes if None.
    """

    seeds: tuple[int, ...] = (62, 63)
    seconds: float = 20.0
    rate: float = 125.0
    spread: tuple[float, float] = (0.8, 1.25)
    spring: float = 35.0
    offsets: tuple[float, ...] = (3.0, -8.0, 5.0, 1.2)
    noise: tuple[float, ...] = (0.5, 0.5, 0.4, 0.1, 0.1, 0.08)
    candidates: tuple[str, ...] = ()
    budget: float | None = None


@dataclass(frozen=True)
class Options(StudyOptions):
    """Where does what a model lacks end up: in its masses, or beside them?

    Attributes:
        seeds: One simulated arm each.
        budget: CPU time of each search [s]; as long as it takes if not given.
    """

    study: ClassVar[str] = "undeclared_masses"
    seeds: Annotated[tuple[int, ...], tyro.conf.arg(metavar="N …")] = Config.seeds
    budget: float | None = None


def run(config: Config, *, smoke: bool) -> list[Row]:
    """One row an arm and link, for both ways; a failure is a row with a reason."""
    rows: list[Row] = []
    for seed in config.seeds:
        with tempfile.TemporaryDirectory() as folder:
            try:
                rows += _rows(config, seed, Path(folder), smoke=smoke)
            except OedError as error:
                rows.append({"seed": seed, "problem": str(error)})
    return rows


def simulate(config: Config, seed: int) -> tuple[DataSet, Float[ndarray, " joints"]]:
    """Four recordings of one arm, and the masses of its links [kg]."""
    rng = np.random.default_rng(seed)
    declared = load_robot(EXAMPLE_ROBOTS / UR5)
    factors = np.repeat(rng.uniform(*config.spread, declared.n), 10)
    true = declared.with_parameters(factors * declared.parameters)
    hidden = [TorqueOffset(j) for j in (0, 1, 2, 4)]
    model = build_model("rotor", true, sign_width=0.01).with_effects(
        JointSpring(1, centre=-1.2, constant=False), *hidden
    )
    # Friction and rotors of the size that UR5 calibrations report; large joints first.
    large = np.arange(declared.n) < 3
    friction = np.where(large[:, None], [8.0, 10.0], [2.5, 2.0]) * rng.uniform(0.8, 1.2, (6, 2))
    own = (friction.ravel(), np.where(large, 1.5, 0.2), [config.spring], config.offsets)
    parameters = np.concatenate([true.parameters, *own])
    motions = [_motion(config, rng) for _ in ROLES]
    torques = [model.torque(parameters, motion) for motion in motions]
    dataset = DataSet.from_arrays(
        declared,
        t=[motion.t for motion in motions],
        q=[m.q + 1e-5 * rng.normal(size=m.q.shape) for m in motions],
        tau=[x + np.array(config.noise) * rng.normal(size=x.shape) for x in torques],
        roles=list(ROLES),
    )
    return dataset, true.parameters[::10]


def _motion(config: Config, rng: np.random.Generator) -> Motion:
    """Five harmonics a joint about a posture with bent elbow, within about a radian."""
    t = np.arange(0.0, config.seconds, 1 / config.rate)[:, None, None]
    w = 2 * np.pi * np.array(HARMONICS)
    sines, cosines = rng.normal(size=(2, 6, len(w)))
    s, c = np.sin(w * t), np.cos(w * t)
    q = (sines * s + cosines * c).sum(axis=2)
    dq = (w * (sines * c - cosines * s)).sum(axis=2)
    ddq = -(w**2 * (sines * s + cosines * c)).sum(axis=2)
    reach = np.array([1.3, 0.9, 1.0, 1.2, 1.2, 1.2]) / np.abs(q).max(axis=0)
    posture = np.array([0.0, -1.2, 1.0, -0.5, 0.3, 0.0])
    return Motion(t.ravel(), posture + reach * q, reach * dq, reach * ddq)


def _rows(config: Config, seed: int, folder: Path, *, smoke: bool) -> Iterator[Row]:
    dataset, truth = simulate(config, seed)
    data = folder / "data"
    write_dataset(dataset, data)
    given = {"data": data, "smoke": smoke, "quiet": True}
    feasible.run(Feasible(**given, out=folder / "alone"))
    told = Calibrate(
        **given,
        out=folder / "whole",
        to=("numpy",),
        candidates=config.candidates,
        budget=config.budget,
        seed=seed,
    )
    calibrate.run(told)
    record = read_json(folder / "whole" / "calibration.json")
    alone, whole = (load_model(folder / place / NAME) for place in ("alone", "whole/feasible"))
    rolled = record["rollout"]["models"]
    flange = {k: v["flange_mm"][-1] for k, v in rolled.items() if v["flange_mm"] is not None}
    robot: Robot = dataset.robot
    for i, joint in enumerate(robot.joints):
        yield {
            "seed": seed,
            "link": joint.link,
            "truth [kg]": float(truth[i]),
            "file [kg]": float(robot.parameters[10 * i]),
            "feasible alone [kg]": float(alone.parameters[10 * i]),
            "calibrate [kg]": float(whole.parameters[10 * i]),
            "named": ", ".join(f"{e['name']}@{e['joint'] + 1}" for e in record["effects"]),
            "base in bodies, 2 s [mm]": flange.get(BASE_OF_BODIES),
            "calibrate, 2 s [mm]": flange.get("feasible"),
        }


def summarise(rows: Sequence[Row]) -> str:
    """The largest factor of any link, and the table."""
    done = [row for row in rows if "problem" not in row]

    def worst(column: str) -> float:
        ratios = [float(row[column]) / float(row["truth [kg]"]) for row in done]  # pyright: ignore[reportArgumentType]
        return max(max(r, 1 / r) for r in ratios)

    lines = ["# What a model lacks, in its masses or beside them", ""]
    if done:
        arms = len({row["seed"] for row in done})
        text = (
            f"{len(done)} links of {arms} simulated UR5 with an undeclared spring and offsets, bodies "
            "within a factor of 1.25 of the file's. The largest factor between a link's estimated and "
            f"true mass: {worst('feasible alone [kg]'):.3g} by `oed feasible` alone, "
            f"{worst('calibrate [kg]'):.3g} by `oed calibrate`. The last columns are a simulation's error "
            "at the last link after 2 s, with the base model in bodies that exist and with the calibrated one."
        )
        lines += [text, ""]
    return "\n".join([*lines, markdown_table(rows), ""])


def main(arguments: Sequence[str] | None = None) -> None:
    """Run from the command line."""
    options = parse(Options, prog="python -m studies.undeclared_masses", arguments=arguments)
    config = Config(seeds=options.seeds, budget=options.budget)
    if options.smoke:
        few = ("torque_offset", "joint_spring")
        config = Config(seeds=options.seeds[:1], seconds=6.0, candidates=few)
    with options.held() as results:
        rows = run(config, smoke=options.smoke)
        with results.replaced() as new:
            write_csv(new / "runs.csv", rows)
            write_atomically(new / "summary.md", summarise(rows))
            Provenance.collect(config, seed=config.seeds[0]).write(new / "provenance.json")
    sys.stdout.write(summarise(rows))


if __name__ == "__main__":
    leave(main, "studies.undeclared_masses")
