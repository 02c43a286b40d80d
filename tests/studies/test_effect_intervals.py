"""Coverage of the intervals of effects: the page's arithmetic, the truths, and one case."""

import dataclasses

import numpy as np
import pytest

from oed.dynamics.effects import State
from oed.dynamics.effects.position import TorqueRipple
from oed.robot.builtin import imi_scara
from studies import effect_intervals
from studies.bench.forms import FORMS
from studies.bench.robots import ROBOTS
from studies.interval_summary import Interval, clopper_pearson, packed, page, unpacked
from studies.row_file import RowFile


def scara_arm():
    arm = ROBOTS["scara"].arm(imi_scara(), np.random.default_rng(0))
    return dataclasses.replace(arm, peak=(25.0, 4.0))


def test_exact_intervals_of_a_share_are_the_published_ones():
    # Newcombe 1998, Statistics in Medicine 17(8), table I: 81 of 263, 15 of 148, 0 of 20, 1 of 29.
    published = {
        (81, 263): (0.2527, 0.3676),
        (15, 148): (0.0578, 0.1617),
        (0, 20): (0.0, 0.1684),
        (1, 29): (0.0009, 0.1776),
    }
    for (hits, trials), expected in published.items():
        assert clopper_pearson(hits, trials) == pytest.approx(expected, abs=6e-5)


def test_page_counts_what_is_covered():
    rows = [
        {
            "effect": "constant",
            "hidden": "constant",
            "robot": "scara",
            "noise": "white",
            "repeated": "yes",
            "seed": str(k),
            "status": "done",
            "intervals": packed([Interval("offset", 1.0, 1.0 + error, 0.1)]),
        }
        for k, error in enumerate((0.1, -0.19, 0.2, 0.0))
    ]
    text = page(rows)
    assert "3 of 4 intervals (75.0 %)" in text
    assert "4 of 4 data sets gave intervals" in text
    assert unpacked(rows[0]["intervals"])[0].z == pytest.approx(1.0)


@pytest.mark.parametrize("key", effect_intervals.COMPARED)
def test_every_form_says_what_it_injects_in_the_catalogue_s_terms(key):
    injected = FORMS[key].inject(
        scara_arm(), 1 - FORMS[key].has_outer, 1.0, np.random.default_rng(1)
    )
    assert injected.in_catalogue
    assert all(np.isfinite(value) for value in injected.in_catalogue.values())


def test_a_wave_is_the_same_torque_on_both_sides():
    arm = scara_arm()
    injected = FORMS["ripple"].inject(arm, 1, 1.0, np.random.default_rng(4))
    values = injected.in_catalogue
    q = np.linspace(-1.0, 1.0, 7)
    zero = np.zeros(7)
    state = State(zero, [zero, q], [zero, zero], [zero, zero])
    columns = TorqueRipple(1, (values["harmonic"],)).entries(state)
    mine = values["ripple*_cos_*"] * columns[0][1] + values["ripple*_sin_*"] * columns[1][1]
    np.testing.assert_allclose(mine, injected.arm.extra[-1](state, [zero, zero])[1], atol=1e-12)


def test_each_arm_and_each_noise_takes_its_turn():
    cases = effect_intervals.cases_of(effect_intervals.Config())
    assert len({case.key for case in cases}) == len(cases)
    assert {case.robot for case in cases} == {"scara", "vertical"}
    assert {case.noise for case in cases} == {"white", "coloured", "felt"}


def test_smoke_leaves_a_line_a_page_and_where_they_come_from(tmp_path):
    effect_intervals.main(["--smoke", "--out", str(tmp_path)])
    assert (tmp_path / "provenance.json").is_file()
    columns = effect_intervals.KEY_COLUMNS, effect_intervals.VALUE_COLUMNS
    (row,) = RowFile(tmp_path / effect_intervals.RUNS, *columns).rows()
    (interval,) = unpacked(row["intervals"])
    assert row["status"] == "done"
    assert interval.name == "offset"
    assert abs(interval.z) < 5
    assert "intervals" in (tmp_path / "summary.md").read_text(encoding="utf-8")
