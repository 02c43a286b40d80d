"""Commands from a data set to what it says: oed check, identify, feasible and diagnose."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from oed.commands.configurations.command import DataCommand, DataSetCommand, ModelName, Prior
from oed.commands.options import Mass, NotNegative, OutFolder, Range, Seed, Whole
from oed.estimation.feasible.weight_range import LEAST_WEIGHT, MOST_WEIGHT


@dataclass(frozen=True, kw_only=True)
class Check(DataSetCommand):
    """Look a data set over before any fit: units, signs, ranges, noise, what it cannot determine.

    Each finding is green, amber or red; a cause is named only if it alone repairs the fit. Leaves
    check.json and report.html, and says which design completes the data. The exit status is 3 if
    something has to be mended first.

    Attributes:
        out: Folder for check.json and report.html; the findings are only printed if not given.
    """

    out: OutFolder | None = None  # pyright: ignore[reportIncompatibleVariableOverride]


@dataclass(frozen=True, kw_only=True)
class Identify(DataSetCommand):
    """Estimate the dynamic parameters of an arm, with intervals, and validate them.

    Leaves model.json, estimate.json, parameters.csv and report.html.

    Attributes:
        model: Torque model: standard, offset or rotor, or a model.json with its effects; if not given,
            rotor where the data set declares gears and determines rotor inertias, else standard.
        robust: Use Huber's loss in place of least squares.
    """

    model: ModelName | Path | None = None  # pyright: ignore[reportIncompatibleVariableOverride]
    robust: bool = False


@dataclass(frozen=True, kw_only=True)
class Feasible(DataSetCommand):
    """Estimate parameters that belong to real bodies, and write URDF, SDF and MJCF with them.

    Leaves model.json, estimate.json, parameters.yaml, calibrated_robot.urdf, .sdf, .xml and report.html. Each
    robot file is loaded again and its torques are compared.

    Attributes:
        model: Torque model: standard, offset or rotor, or a model.json with its effects; if not given,
            rotor where the data set declares gears and determines rotor inertias, else standard.
        prior: Reference bodies for what the data leave open: the robot file's (file), bodies of the
            size of the links (neutral), or the file's where they are no placeholders (auto).
        kind: Measure of the distance to the reference.
        weight: Weight of that distance, from 1e-12 to 1e6; by cross-validation if not given.
        total_mass: Mass of all moving links together [kg], where it is known.
        collision: Keep each link's mass within its collision geometry.
        smoke: Do less, to see that it works.
        seed: Seed of poses and bootstrap.
    """

    model: ModelName | Path | None = None  # pyright: ignore[reportIncompatibleVariableOverride]
    prior: Prior = "auto"
    kind: Literal["entropic", "quadratic"] = "entropic"
    weight: Annotated[float, Range(LEAST_WEIGHT, MOST_WEIGHT)] | None = None
    total_mass: Mass | None = None
    collision: bool = False
    smoke: bool = False
    seed: Seed = 0


@dataclass(frozen=True, kw_only=True)
class Diagnose(DataCommand):
    """Find out what the torque model lacks, add it, and show the error before and after.

    One criterion adds, drops and names every term; test recordings only report. Leaves
    diagnosis.json, report.html, model.json, figures and, where two causes cannot be told apart, the
    motion that tells them apart.

    Attributes:
        model: Base model: standard, offset or rotor; as oed identify chooses it if not given. Or a
            model.json, to look for what that still lacks.
        max_effects: Most effects to add; three a joint if not given, at least six;
            0 only tests the model.
        candidates: Effects that may be named; the whole catalogue if not given.
        smoke: Do less, to see that it works.
        seed: Seed of everything random.
        budget: CPU time after which nothing more is looked for [s].
    """

    max_effects: Whole | None = None
    candidates: tuple[str, ...] = ()
    smoke: bool = False
    seed: Seed = 0
    budget: NotNegative | None = None
