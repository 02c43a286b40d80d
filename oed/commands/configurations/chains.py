"""Commands that run others in a row: oed calibrate and oed demo."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from oed.commands.configurations.command import Command, DataCommand, ModelName, Prior
from oed.commands.options import NotNegative, OutFolder, Rate, Seed, Whole


@dataclass(frozen=True, kw_only=True)
class Calibrate(DataCommand):
    """From recordings to a model that runs: identify, diagnose, estimate bodies, export.

    What the model lacks is found before bodies are estimated, so that it does not end up in masses.
    Leaves a folder for each step and index.html, which links their pages.

    Attributes:
        model: Base model of all steps: standard, offset or rotor; as oed identify chooses it if not
            given.
        to: Forms that the model is exported to; see oed export.
        rate: Rate at which a controller or a simulation asks for torque [Hz].
        prior: Reference bodies: file, neutral or auto; see oed feasible.
        max_effects: Most effects to add; three a joint if not given, at least six.
        candidates: Effects that may be named; the whole catalogue if not given.
        budget: CPU time after which the diagnosis looks for nothing more [s].
        refine: Fit simulations to the measured motion too (rollout); kept only if neither torque nor
            simulation of the validation recordings gets worse.
        smoke: Do less, to see that it works.
        seed: Seed of everything random.
    """

    model: ModelName | None = None  # pyright: ignore[reportIncompatibleVariableOverride]
    to: tuple[str, ...] = ("c", "mujoco")
    rate: Rate = 1000.0
    prior: Prior = "auto"
    max_effects: Whole | None = None
    candidates: tuple[str, ...] = ()
    budget: NotNegative | None = None
    refine: Literal["rollout"] | None = None
    smoke: bool = False
    seed: Seed = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.to:
            raise ValueError("--to: name at least one form, such as mujoco")


@dataclass(frozen=True, kw_only=True)
class Demo(Command):
    """Go the whole way once on a simulated arm: design, record, check, identify, diagnose, export.

    The arm is the paper's two-link SCARA, with a cable that its model does not declare. Leaves a
    folder for each step, and index.html, which links their pages.

    Attributes:
        out: Folder for everything.
        hidden: What the arm has and its model lacks.
        smoke: Do less, to see that it works.
        seed: Seed of motions, noise and everything else that is random.
    """

    out: OutFolder = Path("oed-demo")
    hidden: Literal["cable", "stribeck", "none"] = "cable"
    smoke: bool = False
    seed: Seed = 0
