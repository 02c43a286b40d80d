"""Everything that the study of the paper's experiment may be told."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from pathlib import Path

from oed.experiment.paper_signals import Processing
from studies.paper_experiment.campaign import CampaignConfig
from studies.paper_experiment.designs import DesignConfig

PERIOD = 0.001  # [s], the paper's T


@dataclass(frozen=True)
class Config:
    """The whole study.

    Attributes:
        out: Where the results go.
        cache: Where finished stages are kept.
        designs: How trajectories are designed.
        campaign: How experiments are made.
        experiments: Of the Monte Carlo, a cell.
        processings: Of the signals in the Monte Carlo.
        comparisons: Experiments behind the tables of processing and energy.
        drake_seconds: How much of the J_k trajectory is run on Drake too [s].
        workers: Processes.
    """

    out: Path = Path("results/paper")
    cache: Path = Path("out/paper_cache")
    designs: DesignConfig = field(default_factory=DesignConfig)
    campaign: CampaignConfig = field(default_factory=CampaignConfig)
    experiments: int = 200
    processings: tuple[Processing, ...] = ("online", "parallel")
    comparisons: int = 40
    drake_seconds: float = 2.0
    workers: int = 2

    def smoke(self) -> Config:
        """The same study, as small as it can be."""
        return dataclasses.replace(
            self,
            designs=dataclasses.replace(
                self.designs,
                horizons=(2.0,),
                population=16,
                generations=6,
                runs=2,
                more_terms=(5,),
                exact_seconds=0.2,
            ),
            experiments=3,
            comparisons=2,
            drake_seconds=0.05,
            workers=1,
        )
