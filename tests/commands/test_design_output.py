"""What a design says of itself."""

from oed.commands.design_output import kept_clear


def test_a_motion_that_keeps_clear_and_tells_more_is_not_said_to_cost():
    """J_k is to be small and J_d large: the words stand beside numbers that may move either way."""
    said = kept_clear({"J_k": 351.0, "J_d_log10": 120.4}, 314.0, 120.6)
    assert said.endswith(
        "J_k from 351 to 314 (small is good), J_d from 120.40 to 120.60 (large is good)"
    )
    assert "cost" not in said
