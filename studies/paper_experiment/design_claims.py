"""What the paper claims of its designs: generations, terms, speed."""

from __future__ import annotations

import numpy as np

from studies.paper_experiment.campaign import JOINTS
from studies.paper_experiment.designs import DesignSet, HorizonTable
from studies.paper_experiment.finding import NOWHERE, Finding, Verdict, judged, ratio_interval
from studies.paper_experiment.values import GENERATIONS


def generations(designs: DesignSet) -> list[Finding]:
    """How soon the best J_k run is near its end."""
    best = designs.best_so_far[0]
    reached = float(np.argmax(best <= 1.05 * best[-1]))
    verdict: Verdict = "confirmed" if reached < GENERATIONS else "refuted"
    return [
        Finding(
            "the optimum is found in under 20 generations",
            "generations of the best J_k run until within 5 % of its end",
            *NOWHERE,
            reached,
            reached,
            reached,
            "-",
            verdict,
        )
    ]


def more_terms(table: HorizonTable) -> list[Finding]:
    """What more sines than the paper's three bring."""
    found = []
    for k in range(1, len(table.terms)):
        if table.terms[k] < table.terms[0]:
            continue
        interval = ratio_interval(np.log(table.J_k_by_terms[k] / table.J_k_by_terms[0]))
        _, lower, upper = interval
        verdict: Verdict = "refuted" if upper < 1 else "confirmed" if lower > 1 else "undecided"
        found.append(
            Finding(
                "more than three sines give no significant improvement",
                f"J_k with W = {table.terms[k]} over W = {table.terms[0]}, same generations",
                *NOWHERE,
                *interval,
                "-",
                verdict,
            )
        )
    return found


def speed(table: HorizonTable) -> list[Finding]:
    """How fast designs of both criteria move."""
    chosen = int(np.argmin(np.abs(table.horizon - table.chosen)))
    ratio = np.log(table.speed[1, chosen] / table.speed[0, chosen])
    return [
        judged(
            "J_d-optimal trajectories move faster",
            f"rms speed of J_d over J_k, joint {j + 1}, over seeds of the algorithm",
            NOWHERE,
            ratio_interval(ratio[:, j]),
            "-",
            expected="above",
            pivot=1.0,
        )
        for j in range(JOINTS)
    ]
