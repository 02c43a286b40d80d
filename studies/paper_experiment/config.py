"""Everything that the study of the paper's experiment may be told."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from pathlib import Path

from studies.paper_experiment.laboratory import LaboratoryConfig
from studies.paper_experiment.searches import DesignConfig


@dataclass(frozen=True)
class Config:
    """The whole study.

    Attributes:
        out: Where the results go.
        cache: Where finished stages are kept.
        designs: How trajectories are designed.
        laboratory: How experiments are made.
        draws: Of the noise, on every design and every test motion; an even number, as halves of
            them tell the noise from the rest.
        drake_seconds: How much of the J_k trajectory is run on Drake too [s].
    """

    out: Path = Path("results/paper")
    cache: Path = Path("out/paper_cache")
    designs: DesignConfig = field(default_factory=DesignConfig)
    laboratory: LaboratoryConfig = field(default_factory=LaboratoryConfig)
    draws: int = 4
    drake_seconds: float = 2.0

    def __post_init__(self) -> None:
        if self.draws < 2 or self.draws % 2:
            raise ValueError(f"{self.draws} draws of the noise: an even number is needed")

    def smoke(self) -> Config:
        """The same study, as small as it can be."""
        designs = dataclasses.replace(
            self.designs,
            horizons=(1.0,),
            # So few bits that the algorithm converges, as the figures claim.
            bits=2,
            terms=2,
            more_terms=3,
            population=20,
            generations=25,
            large_population=24,
            large_generations=20,
            runs=2,
            horizon_runs=1,
            pairs=2,
            tests=2,
            exact_evaluations=40,
        )
        laboratory = dataclasses.replace(
            self.laboratory,
            laboratory=dataclasses.replace(self.laboratory.laboratory, settling=0.3),
            repetitions=2,
            variance_repetitions=4,
        )
        return dataclasses.replace(
            self,
            cache=self.cache / "smoke",
            designs=designs,
            laboratory=laboratory,
            draws=2,
            drake_seconds=0.05,
        )
