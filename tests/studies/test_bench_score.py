import numpy as np
import pytest
from scipy.stats import binomtest

from studies.bench import judge as judge_module
from studies.bench.case import KEY_COLUMNS, Case
from studies.bench.judge import VALUE_COLUMNS, Judge
from studies.bench.rates import Rate
from studies.bench.reliability import reliability, stated_text
from studies.bench.score import error_ratios, score
from studies.bench.study import Config, main, run
from studies.bench.summary import (
    clean_table,
    confusion,
    detection,
    group_table,
    page,
    pair_detection,
    time_table,
)
from studies.bench.truth import HiddenTruth, Truth

STAND_IN = """
import json, sys
from pathlib import Path
out = Path(sys.argv[sys.argv.index("--out") + 1])
data = Path(sys.argv[sys.argv.index("--data") + 1])
assert (data / "dataset.toml").is_file()
out.mkdir(parents=True)
same = {"estimation": [1.0, 1.0], "validation": [1.0, 1.0], "test": [1.0, 1.0]}
diagnosis = {"verdict": "nothing found", "effects": [], "unexplained": [],
             "rms": {"before": same, "after": same, "noise_floor": same}}
(out / "diagnosis.json").write_text(json.dumps(diagnosis))
"""


def hidden(name, joint, kind="plain", parameters=None, coordinates=()):
    return HiddenTruth(name, name, kind, joint, parameters or {}, coordinates)


def truth(*effects):
    return Truth(effects, (0.5, 0.1), (0.2, 0.02))


def claim(name, joint, rivals=(), probability=0.99, **parameters):
    return {
        "name": name,
        "joint": joint,
        "probability": probability,
        "alternatives": [{"name": n, "joint": j, "contender": c} for n, j, c in rivals],
        "parameters": {
            key: {"value": v, "std": s, "unit": u} for key, (v, s, u) in parameters.items()
        },
    }


def diagnosis(*claims, verdict="explained", unexplained=()):
    return {"verdict": verdict, "effects": list(claims), "unexplained": list(unexplained)}


def test_the_right_name_at_the_right_joint_is_found():
    found = score(diagnosis(claim("stribeck", 1)), truth(hidden("stribeck", 1)), 2)
    assert (found.found, found.missed, found.extra) == (1, 0, 0)
    assert found.claims == ("stribeck@2",)


def test_the_right_name_at_another_joint_is_missed_and_false():
    found = score(diagnosis(claim("stribeck", 0)), truth(hidden("stribeck", 1)), 2)
    assert (found.found, found.missed, found.extra) == (0, 1, 1)


def test_one_claim_accounts_for_one_effect_only():
    both = truth(hidden("stribeck", 0), hidden("stribeck", 1))
    found = score(diagnosis(claim("stribeck", 1)), both, 2)
    assert (found.found, found.missed, found.extra) == (1, 1, 0)


def test_a_name_where_nothing_is_hidden_is_false():
    found = score(diagnosis(claim("backlash", 0)), truth(), 2)
    assert (found.found, found.missed, found.extra) == (0, 0, 1)


def test_delay_for_lag_is_nearly_right():
    found = score(diagnosis(claim("filter_lag", None)), truth(hidden("time_delay", None)), 2)
    assert (found.found, found.nearly, found.missed, found.extra) == (0, 1, 0, 0)


def test_a_rival_counts_only_if_it_is_left_open():
    for is_open, expected in ((True, (1, 0)), (False, (0, 1))):
        said = diagnosis(claim("backlash", 0, rivals=(("stribeck", 0, is_open),)))
        found = score(said, truth(hidden("stribeck", 0)), 2)
        assert (found.nearly, found.extra) == expected


def test_on_two_joints_either_gain_is_right_and_on_six_only_one():
    said, what = diagnosis(claim("torque_gain", 0)), truth(hidden("torque_gain", 1))
    assert score(said, what, 2).found == 1
    assert score(said, what, 6).found == 0


def test_the_coordinates_of_a_stranger_have_to_be_right_at_its_joint():
    stranger = truth(hidden("outside", 1, "outside", coordinates=(("dq_2", "q_1"),)))

    def said(joint, *names):
        entry = {"joint": joint, "depends_on": list(names), "share": 0.5}
        return diagnosis(verdict="unexplained", unexplained=(entry,))

    assert score(said(1, "q_1", "dq_2"), stranger, 2).coordinates_right is True
    assert score(said(0, "q_1", "dq_2"), stranger, 2).coordinates_right is False
    assert score(said(1, "q_1"), stranger, 2).coordinates_right is False
    assert score(diagnosis(), truth(), 2).coordinates_right is None


def test_an_interval_is_judged_where_one_parameter_means_the_same():
    what = truth(hidden("joint_spring", 0, parameters={"stiffness": (2.0, "N m/rad")}))

    def said(value, std):
        return diagnosis(claim("joint_spring", 0, k_1=(value, std, "N m/rad"), c=(0, 1, "N m")))

    assert (score(said(2.1, 0.1), what, 2).covered, score(said(2.3, 0.1), what, 2).covered) == (
        1,
        0,
    )
    twice = claim("joint_spring", 0, a=(2.0, 0.1, "N m/rad"), b=(2.0, 0.1, "N m/rad"))
    assert score(diagnosis(twice), what, 2).compared == 0


def test_errors_are_compared_joint_by_joint():
    rms = {
        "before": {"test": [2.0, 1.0]},
        "after": {"test": [1.0, 1.1]},
        "noise_floor": {"test": [1.0, 1.0]},
    }
    ratios = error_ratios(rms)
    assert ratios.after_to_floor == pytest.approx(1.1)
    assert ratios.after_to_before == pytest.approx(1.1)
    assert ratios.removed == pytest.approx(1.0)


@pytest.mark.parametrize(("hits", "cases"), [(0, 20), (3, 20), (20, 20)])
def test_the_interval_of_a_rate_is_that_of_clopper_and_pearson(hits, cases):
    expected = binomtest(hits, cases).proportion_ci(0.95, method="exact")
    np.testing.assert_allclose(
        Rate(hits, cases).interval, (expected.low, expected.high), atol=1e-12
    )


def line(group, form, claims="", verdict="explained", size=1.0, **values):
    row = dict.fromkeys((*KEY_COLUMNS, *VALUE_COLUMNS), "0")
    row |= {"group": group, "hidden": form, "claims": claims, "verdict": verdict}
    row |= {"status": "done", "coordinates_right": "", "stated": ""}
    row |= {"size_in_noise": str(size), "smaller_in_noise": str(size)}
    row |= {"noise": "white", "repeated": "yes", "after_to_floor": "1.0", "removed": "0.5"}
    return row | {key: str(value) for key, value in values.items()}


def test_what_was_hidden_is_counted_against_what_was_said():
    rows = [
        line("clean", "", verdict="nothing found"),
        line("clean", "", "backlash@1", extra=1),
        line("single", "spring", "joint_spring@1 torque_offset@2", found=1, extra=1),
        line("outside", "landscape", verdict="unexplained", coordinates_right="yes"),
    ]
    counts = confusion(rows)
    assert counts["nothing", "nothing"] == counts["nothing", "backlash"] == 1
    assert counts["joint_spring", "joint_spring"] == counts["joint_spring", "torque_offset"] == 1
    assert counts["outside", "no name claimed"] == 1
    table = {row["group"]: row for row in group_table(rows)}
    assert str(table["clean"]["right"]).startswith("1 of 2")
    assert str(table["single"]["right"]).startswith("1 of 1")
    assert str(table["single"]["right, nothing else"]).startswith("0 of 1")
    assert str(clean_table(rows)[-1]["something named"]).startswith("1 of 2")


def test_names_are_counted_by_the_probability_that_is_stated_for_them():
    both = truth(hidden("stribeck", 1), hidden("filter_lag", None))
    claims = (
        claim("stribeck", 1, probability=1.0),
        claim("time_delay", None, probability=0.97),  # accounts for the lag
        claim("backlash", 0, probability=0.96),
    )
    stated = score(diagnosis(*claims), both, 2).stated
    assert stated == ((1.0, True), (0.97, True), (0.96, False))
    rows = [line("pair", "stribeck+lag", stated=stated_text(stated)), line("clean", "")]
    low, high = reliability(rows)
    assert (low["from"], low["to"], low["names"]) == (0.95, 0.99, 2)
    assert (low["stated"], low["right"]) == (pytest.approx(0.965), 0.5)
    assert (high["to"], high["names"], high["right"], high["upper"]) == (1.0, 1, 1.0, 1.0)


def test_what_a_diagnosis_takes_is_told_by_state_and_joints():
    rows = [
        line("single", "spring", robot=robot, code=code, seconds=seconds)
        for robot, code, seconds in (
            ("scara", "old", 50.0),
            ("scara", "new", 30.0),
            ("vertical", "new", 31.0),
            ("panda", "new", 299.0),
            ("ur5", "new", 301.0),
        )
    ]
    table = {(row["state"], row["joints"]): row for row in time_table(rows)}
    assert list(table) == [("`old`", "two"), ("`new`", "two"), ("`new`", "six or seven")]
    assert [row["longest [s]"] for row in table.values()] == [50.0, 31.0, 301.0]
    in_time = [str(row["in time"])[:6] for row in table.values()]
    assert in_time == ["0 of 1", "1 of 2", "1 of 2"]


def test_a_failed_case_is_a_line_and_no_rate():
    rows = [line("single", "spring", status="failed: Boom: no", verdict="")]
    (row,) = group_table(rows)
    assert (row["cases"], row["failed"], row["right"]) == (1, 1, "–")
    assert "1 × failed: Boom: no" in page(rows, "Note.")


def test_detection_is_counted_by_size():
    rows = [
        line("size", "spring", verdict="nothing found", size=0.03, missed=1),
        line("single", "spring", "joint_spring@1", size=0.5, found=1),
        line("single", "spring", "backlash@1", size=0.6, missed=1, extra=1),
    ]
    small, large = detection(rows)
    assert (small["noticed"], small["right"]) == (0.0, 0.0)
    assert (large["cases"], large["noticed"], large["right"]) == (2, 1.0, 0.5)


def test_a_pair_is_counted_by_the_smaller_of_the_two():
    rows = [
        line("pair", "spring+ripple", "joint_spring@1", size=2.0, smaller_in_noise=0.02, missed=1),
        line("pair", "spring+gain", "joint_spring@1 torque_gain@2", size=0.9, found=2),
    ]
    assert [(row["from"], row["right"]) for row in pair_detection(rows)] == [(0.0, 0.0), (0.8, 1.0)]
    assert not detection(rows)


def test_a_run_goes_on_where_it_stopped(tmp_path, monkeypatch):
    (tmp_path / "stand_in.py").write_text(STAND_IN, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    made = []

    def quick_dataset(case, folder):
        made.append(case)
        folder.mkdir(parents=True)
        (folder / "dataset.toml").write_text("format = 1", encoding="utf-8")
        return truth()

    monkeypatch.setattr(judge_module, "make_dataset", quick_dataset)
    cases = [Case("clean", "scara", (), 1.0, "white", True, seed) for seed in range(3)]
    config = Config(("clean",), 3, module="stand_in")
    out, folder = tmp_path / "results", tmp_path / "work"
    run(config, cases[:2], out, folder)
    rows = run(config, cases, out, folder)
    assert made == cases
    assert [row["status"] for row in rows] == ["done"] * 3
    main(["--summarise", "--out", str(out), "--folder", str(folder)])
    assert "3 of 3" in (out / "summary.md").read_text(encoding="utf-8")
    assert {"runs.csv", "provenance.json", "confusion.png", "errors.png"} <= {
        file.name for file in out.iterdir()
    }


def test_a_diagnosis_that_fails_is_a_line(tmp_path, monkeypatch):
    monkeypatch.setattr(judge_module, "make_dataset", lambda case, folder: truth())
    case = Case("clean", "scara", (), 1.0, "white", True, 0)
    config = Config(("clean",), 1, module="no_such_module_anywhere")
    (row,) = run(config, [case], tmp_path / "results", tmp_path / "work")
    assert str(row["status"]).startswith("failed: DiagnosisFailed")


def test_the_judge_keeps_truth_away_from_the_data(tmp_path, monkeypatch):
    monkeypatch.setattr(judge_module, "make_dataset", lambda case, folder: truth())
    judge = Judge(tmp_path)
    case = Case("clean", "scara", (), 1.0, "white", True, 0)
    assert judge.prepare(case) == truth()
    assert (tmp_path / "truth" / f"{case.label}.json").is_file()
    assert not list((tmp_path / "data").rglob("*.json"))
