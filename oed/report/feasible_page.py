"""The page of a feasible calibration: verdict, residuals, links, parameters, weight, checks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oed.checkup.checkup import doubts_of_data
from oed.checkup.finding import Checkup
from oed.estimation.feasible.bootstrap import MOSTLY_DATA
from oed.estimation.feasible.calibration import FeasibleCalibration
from oed.estimation.feasible.change_from_file import LinkChange
from oed.estimation.feasible.cross_validation import TOLERANCE
from oed.experiment.recording import HELD_OUT, Role
from oed.report.chart import Chart
from oed.report.feasible_charts import (
    centre_chart,
    margin_chart,
    mass_chart,
    residual_comparison_chart,
    weight_chart,
)
from oed.report.feasible_rows import (
    change_rows,
    link_rows,
    parameter_rows,
    solver_comparison,
    validation_rows,
)
from oed.report.joint_words import torque_label
from oed.report.origin_section import origin_section
from oed.report.page import Page, Section, Table, Text, Verdict
from oed.report.parameter_charts import interval_charts
from oed.report.provenance import Provenance
from oed.report.table import Row

AT_BOUND = (
    "Parameters on which a demand presses, by themselves or as part of a link, are marked "
    "`at_bound`. Estimates from resampled data stay at that bound, so that these intervals are "
    "narrow, or without any width, whatever the data say: they show the demand, not how far the "
    "truth may be. Those of parameters that are correlated with them are too narrow as well."
)


def feasible_page(
    result: FeasibleCalibration,
    exports: Sequence[Row],
    provenance: Provenance,
    *,
    checkup: Checkup,
) -> Page:
    """The whole page.

    Args:
        result: To show.
        exports: One row a written robot file, with its round trip.
        provenance: Of the run.
        checkup: Of its data.
    """
    notes = [Text(f"Note on the data: {note}.") for note in doubts_of_data(checkup)]
    return Page(
        title=f"Physically feasible parameters of {result.plain.dataset.name}",
        verdict=_verdict(result, is_doubted=bool(notes)),
        sections=(
            Section(
                "How well it predicts",
                (*notes, Table(validation_rows(result)), *_comparisons(result)),
            ),
            _change_section(result),
            _links_section(result),
            _parameters_section(result),
            _weight_section(result),
            _proof_section(result, exports),
            origin_section(result.plain, provenance),
        ),
    )


def _comparisons(result: FeasibleCalibration) -> list[Chart]:
    robot = result.plain.dataset.robot
    held_out: list[Role] = [role for role in HELD_OUT if role in result.validation]
    return [
        residual_comparison_chart(
            robot.joint_names,
            result.plain.validation[role].rms,
            result.validation[role].rms,
            label=torque_label(robot.joints, "rms residual torque"),
            caption=f"Residual by joint, recordings with role {role}.",
        )
        for role in held_out
    ]


def _verdict(result: FeasibleCalibration, *, is_doubted: bool) -> Verdict:
    held_out: list[Role] = [role for role in HELD_OUT if role in result.validation]
    prices = ", ".join(f"{100 * result.price(role):+.2g} % on {role}" for role in held_out)
    share = 100 * result.positive_definite
    agreed = result.disagreement is not None and result.disagreement < 1e-6
    complete = (
        share == 100.0 and agreed and bool(held_out) and not result.warnings and not is_doubted
    )
    return Verdict(
        "good" if complete else "warning",
        f"All {result.plain.dataset.robot.n} links are physically consistent; the mass matrix is "
        f"positive definite in {share:.4g} % of {result.settings.poses} poses (plain least "
        f"squares: {100 * result.plain_positive_definite:.4g} %).",
        (
            f"Residual against plain least squares: {prices}. "
            if held_out
            else "No recording was kept for validation. "
        )
        + (
            "A second solver agrees."
            if agreed
            else f"No second solver agreed: {result.second_failure or result.disagreement}."
        )
        + (f" {len(result.warnings)} warning(s) below." if result.warnings else ""),
    )


def _links_section(result: FeasibleCalibration) -> Section:
    test, estimate = result.plain_feasibility, result.estimate
    answer = (
        "Whether any feasible robot has the plain estimate's base parameters was not found out: "
        f"{result.plain_feasibility_failure}."
        if test is None
        else f"Some feasible robot has the plain estimate's base parameters, with margin "
        f"{test.margin:.2g}."
        if test.is_feasible
        else "No feasible robot has the plain estimate's base parameters: a dual certificate bounds "
        f"every robot's margin by {test.certificate.bound:.3g} (recomputed to "
        f"{test.certificate.residual:.0e}). It weighs, heaviest first: {', '.join(test.blamed)}."
    )
    active = (
        f"Demands that hold the estimate: {', '.join(estimate.active)}. Intervals are one-sided there."
        if estimate.active
        else "No demand is active: the estimate lies inside all of them."
    )
    return Section(
        "Consistency of the links",
        (
            Table(link_rows(result)),
            margin_chart(
                [joint.link for joint in estimate.robot.joints],
                estimate.relative_margins,
                estimate.problem.margin,
            ),
            Text(active),
            Text(answer),
        ),
    )


def _change_section(result: FeasibleCalibration) -> Section:
    warnings = [Text(f"Warning: {warning}.") for warning in result.warnings]
    pull = Text(f"Links are pulled to {result.inertials.reason}.")
    if not result.changes:
        return Section("What changed from the robot's file", (*warnings, pull))
    about = Text(
        "Beyond reason is what least squares on the data alone leave open and yet makes the link twice "
        "the body it was: a mass or an inertia that doubled or halved, a centre that moved by more than "
        "the radius of gyration, which doubles the inertia about where it was. `data alone` is a standard "
        "deviation, and empty where no torque depends on that value by itself; inertias are means of the "
        "principal moments about the centre of mass."
    )
    charts = (mass_chart(result.changes), centre_chart(result.changes))
    return Section(
        "What changed from the robot's file",
        (*warnings, _total(result.changes[-1]), pull, about, Table(change_rows(result)), *charts),
    )


def _total(change: LinkChange) -> Text:
    mass = change.mass
    low, high = mass.interval
    percent = 100 * (mass.after / mass.before - 1)
    return Text(
        f"Total mass of the moving links: {mass.after:.4g} kg identified (95 %: {low:.4g} to "
        f"{high:.4g} kg), {mass.before:.4g} kg in the file: {percent:+.1f} %."
    )


def _parameters_section(result: FeasibleCalibration) -> Section:
    estimate = result.estimate
    undecided = int(np.sum(estimate.from_data < MOSTLY_DATA))
    reference = (
        "the inertials of the robot's file"
        if estimate.has_prior
        else "neutral bodies: a rod between the joints of each link, all of the one density that "
        "explains the data best. What no torque depends on is then that of a plain arm of the "
        "right weight"
    )
    measured = np.flatnonzero(estimate.from_data > MOSTLY_DATA)
    charts = interval_charts(
        [estimate.names[k] for k in measured],
        estimate.parameters[measured],
        result.bootstrap.interval()[measured],
        [estimate.units[k] for k in measured],
        caption="Parameters that the data decide, with 95 % intervals.",
    )
    return Section(
        "Parameters",
        (
            Text(
                f"Intervals: {result.bootstrap.method}, wider by 1 / `from_data`, the share of a value that the "
                f"data decide. For {undecided} of {len(estimate.names)} it is below one half, and "
                f"these are close to {reference}: they have no interval, since none would say anything of the truth."
            ),
            *([Text(AT_BOUND)] if estimate.active else []),
            Table(parameter_rows(result)),
            *charts,
        ),
    )


def _weight_section(result: FeasibleCalibration) -> Section:
    pull = result.estimate.problem.regularisation
    text = f"The pull to the reference is {pull.kind}, with weight {pull.weight:.3g}"
    curve = result.curve
    if curve is None:
        return Section("Weight of the pull", (Text(f"{text}, as given."),))
    return Section(
        "Weight of the pull",
        (
            Text(
                f"{text}: the largest whose held-out error is within one standard error of the best, "
                f"or within {100 * TOLERANCE:g} % of it, over {curve.held_out.shape[1]} folds "
                "of consecutive data. The error is the geometric mean over joints of the rms residual."
            ),
            weight_chart(
                curve.weights,
                curve.held_out,
                curve.fitted,
                best=curve.best,
                chosen=curve.chosen,
                least_squares=float(curve.least_squares.mean()),
            ),
        ),
    )


def _proof_section(result: FeasibleCalibration, exports: Sequence[Row]) -> Section:
    lines = [result.estimate.solution.accuracy, *result.estimate.solution.attempts]
    lines += [] if result.second is None else result.second.attempts
    return Section(
        "Checks",
        (
            *(Text(line) for line in lines),
            Text(solver_comparison(result)),
            Table(exports, caption="Robot files, and their torques under the recorded motion."),
        ),
    )
