"""What a design for drawn models gains and costs beside the nominal one."""

from __future__ import annotations

from oed.counted import counted
from oed.design.robust_worth import RobustWorth, Worth
from oed.report.page import Table, Text
from oed.report.table import Row

GOOD = {"J_k": "small", "J_d": "large", "A": "small", "E": "large"}


def robust_worth(doubt: RobustWorth) -> tuple[Table | Text, ...]:
    """Both motions under the same models, and in which way."""
    models = counted(doubt.scenarios, "drawn model")
    mean = "mean" if doubt.criterion == "J_d" else "mean of its logarithm"
    same = "" if doubt.has_shapes else " It is the same under each: no shape was drawn."
    found, other = (
        x.nominal if GOOD[doubt.criterion] == "large" else -x.nominal
        for x in (doubt.robust_design, doubt.nominal_design)
    )
    if found > other:
        same += (
            " The robust motion is better for the nominal model too: the search for that had not come to "
            "its end, and more --evaluations tell more."
        )
    return (
        Table(
            [
                _row("nominal", doubt.nominal_design),
                _row(f"robust, {doubt.aim}", doubt.robust_design),
            ],
            caption=f"Two motions found with as many evaluations, under the same {models}.",
        ),
        Text(
            f"{doubt.criterion} counts what is known before, and {GOOD[doubt.criterion]} is good; expected "
            f"is the {mean} over the drawn models.{same}"
        ),
    )


def _row(name: str, worth: Worth) -> Row:
    row: Row = {
        "motion": name,
        "J of the nominal model": worth.nominal,
        "expected J": worth.expected,
        "worst J": worth.worst,
    }
    if worth.largest_share is not None:
        row["most of a torque limit"] = f"{worth.largest_share:.0%}"
        row["models that exceed one"] = worth.exceeding
    return row
