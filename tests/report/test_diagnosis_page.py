"""The page of a diagnosis: what a reader is promised of it."""

import dataclasses
import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from oed.commands.main import configuration_of
from oed.diagnosis.diagnose import Diagnosis, diagnose
from oed.diagnosis.discrimination.next_motion import NextExperiment
from oed.diagnosis.inference.answer import Alternative, Unexplained
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.dataset import DataSet
from oed.report.diagnosis_page import diagnosis_page
from oed.report.diagnosis_report import write_diagnosis
from oed.report.next_steps import Run, next_steps
from oed.report.page import Page, Picture, Text
from oed.report.provenance import Provenance
from oed.report.style import new_figure
from oed.report.torque_charts import RoleTorques, Rows
from oed.report.unnamed_terms import unnamed_terms
from oed.robot import load_arm
from tests.diagnosis.arm import data_set, stribeck
from tests.experiment.tiny_dataset import urdf_text
from tests.report.html_reader import Reader

JOINTS = ("<b>shoulder</b>", "elbow & wrist")
NAMES = ("stribeck", "torque_offset", "nonlinear_viscous")


RUN = Run(Path("my data"), Path("diagnosis"))
CABLE = 1.5  # [N m/rad]
ROWS = Rows(np.arange(9.0), np.ones((9, 2)), dict.fromkeys(("before", "after"), np.zeros((9, 2))))
TORQUES = (RoleTorques("test", ROWS, dict.fromkeys(ROWS.predicted, np.ones(2)), np.ones(2)),)


def fall_and_cable(q, dq, ddq):
    """Friction of joint 1 that falls with speed, and a cable at joint 2 that no name here describes."""
    torque = stribeck(1.5, 0.15)(q, dq, ddq)
    torque[:, 1] += CABLE * q[:, 1]
    return torque


def measured() -> DataSet:
    return data_set(31, extra=fall_and_cable, repetitions=2)


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    data = measured()
    return diagnose(data, TorqueModel.standard(data.robot), names=NAMES)


def write(found: Diagnosis, out: Path, following: NextExperiment | None = None) -> str:
    write_diagnosis(
        found,
        following,
        torques=TORQUES,
        data="<i>bench</i>",
        joints=JOINTS,
        notes=("the log pauses once",),
        run=RUN,
        provenance=Provenance.collect(CATALOGUE["stribeck"].page, seed=0),
        out=out,
    )
    return (out / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(found, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("page")
    write(found, out)
    return out


@pytest.fixture(scope="module")
def html(folder) -> str:
    return (folder / "report.html").read_text(encoding="utf-8")


def test_needs_no_other_file(html):
    page = Reader(html)
    assert page.references
    assert all(reference.startswith("data:image/") for reference in page.references)
    assert not {"link", "iframe", "object"} & set(page.tags)


def test_names_are_text_and_never_markup(html):
    assert not {"b", "i"} & set(Reader(html).tags)
    for name in (*JOINTS, "<i>bench</i>"):
        assert any(name in text for text in Reader(html).text)


def test_what_is_open_comes_first_then_budget_additions_errors_and_effects(html, found):
    texts = Reader(html).text
    title, _, headline = texts[1:4]
    assert title == "What the model lacks: <i>bench</i>"
    assert headline == (
        "Unexplained: stribeck (joint 1); without a name: at joint 2 torque that depends on its position"
    )
    headings = (
        "There, but without a name",
        "What to do next",
        "Torque budget",
        "What each addition does",
        "Errors before and after",
        "Torque before and after",
        f"stribeck, joint 1 ({JOINTS[0]})",
        "Notes on the data",
    )
    places = [texts.index(heading) for heading in headings]
    assert places == sorted(places)


def undrawn(found: Diagnosis) -> Page:
    """The page with an empty picture."""
    return diagnosis_page(
        found,
        None,
        torques=TORQUES,
        data="bench",
        joints=JOINTS,
        notes=(),
        pictures={"proof": Picture(new_figure(1.0, 1.0), "")},
        run=RUN,
        provenance=Provenance.collect(CATALOGUE["stribeck"].page, seed=0),
    )


def test_where_all_has_a_name_nothing_is_left_to_do(found):
    page = undrawn(dataclasses.replace(found, verdict="explained", unexplained=()))
    assert page.verdict.headline == "Explained: stribeck (joint 1)"
    assert page.sections[0].title == "Torque budget"


def test_tells_every_effect_of_the_record_with_its_parameters_and_rivals(html, folder):
    record = json.loads((folder / "diagnosis.json").read_text())
    assert record["effects"]
    texts = Reader(html).text
    for effect in record["effects"]:
        assert set(effect["parameters"]) <= set(texts)
        assert {rival["words"] for rival in effect["alternatives"]} <= set(texts)


def test_labels_are_for_programs_and_words_for_people(html, folder, found):
    record = json.loads((folder / "diagnosis.json").read_text())
    (left,) = record["unexplained"]
    assert left["term"].startswith("f(q_2)[")
    assert left["words"].startswith(
        "joint 2: torque that depends on its position (a free curve over q_2"
    )
    assert record["budget"]["words"][left["term"]] == left["words"]
    assert left["words"].removeprefix("joint 2: ") in Reader(html).text  # in the budget
    every = " ".join(Reader(html).text)
    assert not [
        s.term.label for k in found.selected.substitutes for s in k if s.term.label in every
    ]


def test_says_how_large_what_has_no_name_is(found):
    (left,) = unnamed_terms(found)
    held = next(e for e in found.errors if e.role == "validation")
    assert left.before == pytest.approx(held.before[1] / found.noise_floor[1])
    assert left.after == pytest.approx(held.after[1] / found.noise_floor[1])
    (recording,) = measured().validation
    pull = np.sqrt(np.mean((CABLE * recording.q[:, 1]) ** 2))
    assert "fitted over q_2 from" in left.model_has
    assert left.carried == pytest.approx(pull / found.noise_floor[1], rel=0.1)


def test_says_what_a_model_that_is_not_certain_of_a_name_has_in_its_place(found):
    (number,) = [e.number for e in found.effects]
    label = found.selected.views.terms[number].label
    doubted = dataclasses.replace(
        found, effects=(), unexplained=(Unexplained(0, ("dq_1",), label, number),)
    )
    (left,) = unnamed_terms(doubted)
    assert left.model_has == "stribeck, not certain"
    assert left.what == "something like stribeck"
    assert left.nearest is not None
    assert (left.nearest.entry.name, left.nearest.behind) == ("stribeck", 0)


def strange(*coordinates: str, joint: int = 1) -> Unexplained:
    return Unexplained(joint, coordinates, "something that no term that was tried describes", None)


def test_every_command_of_what_to_do_next_is_one_that_is_accepted(found, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found_model = tmp_path / "diagnosis" / "model.json"  # which a diagnosis has left by then
    found_model.parent.mkdir()
    found_model.write_text("{}")
    left = dataclasses.replace(
        found, unexplained=(strange(), strange("q_1", "time"), strange("dq_1", joint=0))
    )
    steps = next_steps(left, None, dataclasses.replace(RUN, budget=30.0))
    commands = [shlex.split(line) for step in steps for line in step.commands]
    assert {words[1] for words in commands} == {"design", "diagnose"}
    for words in commands:
        assert words[0] == "oed"
        config = configuration_of(words[1:])
        assert str(config.data) == "my data"


def test_steps_follow_from_what_is_known(found):
    def said(**changed: object) -> str:
        left = dataclasses.replace(found, **changed)
        return " ".join(step.text for step in next_steps(left, None, RUN))

    assert "at full and at half speed" in said()
    assert "at full and at half speed" not in said(unexplained=(strange("time"),))
    assert "cold and warm" in said(unexplained=(strange("time"),))
    assert "cold and warm" not in said()
    assert "Run each motion several times" not in said()
    assert "Run each motion several times" in said(noise_source="smooth fit")
    assert "look once more" in said(unexplained=(strange(),))
    assert "look once more" not in said()
    assert said(verdict="explained", unexplained=()) == ""


def test_a_name_that_no_motion_tells_from_another_is_exposed_as_the_catalogue_says(found):
    (effect,) = found.effects
    other = Alternative("drag@1", "drag", 0, 0.4, same=False, open=True)
    open_name = dataclasses.replace(effect, alternatives=(other,))
    left = dataclasses.replace(found, verdict="ambiguous", effects=(open_name,), unexplained=())
    first, last = next_steps(left, None, RUN)
    assert "Whether it is stribeck (joint 1) is open" in first.text
    assert CATALOGUE["stribeck"].page.exposed_by in first.text
    assert last.commands == ("oed diagnose 'my data' --out again/",)


def test_a_joint_is_moved_alone_only_where_others_may_be_the_cause(found, tmp_path):
    def lines(*left: Unexplained, at: Diagnosis) -> list[str]:
        steps = next_steps(dataclasses.replace(at, unexplained=left), None, RUN)
        return [line for step in steps for line in step.commands if "--joints" in line]

    file = tmp_path / "arm.urdf"
    file.write_text(urdf_text(2))
    robot = load_arm(str(file))
    model = dataclasses.replace(found.before.model, robot=robot)
    filed = dataclasses.replace(found, before=dataclasses.replace(found.before, model=model))
    line = "oed design --data 'my data' --joints joint_2 --out alone_2/"
    assert lines(strange("q_1"), at=filed) == [line]
    assert lines(strange("q_2", "dq_2", "time"), at=filed) == []
    # A built-in robot has no file whose other joints could be held.
    assert lines(strange("q_1"), at=found) == []


def test_more_things_without_a_name_than_a_headline_holds_are_counted_by_joint(found):
    many = tuple(strange("q_1", joint=k % 2) for k in range(5))
    headline = undrawn(dataclasses.replace(found, unexplained=many)).verdict.headline
    assert headline.endswith("without a name: torque at joints 1, 2")


def test_a_floor_that_held_what_was_found_is_said_to_be_too_high(found):
    def said(page: Page) -> list[str]:
        texts = [b.text for x in page.sections for b in x.blocks if isinstance(b, Text)]
        return [text for text in texts if "the noise is lower" in text]

    assert not said(undrawn(found))
    high = found.noise_floor * np.array([3.0, 1.0])
    (words,) = said(undrawn(dataclasses.replace(found, noise_floor=high)))
    assert f"At joint 1 ({JOINTS[0]}) less" in words


def test_a_contradiction_by_the_test_recordings_stands_beside_the_verdict(found, tmp_path):
    label = found.selected.views.terms[found.effects[0].number].label
    told = f"the test recordings contradict {label}: their error is 3 with it and 2 without"
    page = Reader(write(dataclasses.replace(found, contradicted=(told,)), tmp_path / "against"))
    words = (
        "The test recordings contradict stribeck (joint 1): their error is 3 with it and 2 without."
    )
    assert any(words in text for text in page.text[:6])
    record = (tmp_path / "against" / "diagnosis.json").read_text()
    assert words[1:-1] in record


def test_hands_on_the_motion_that_tells_alternatives_apart(found, tmp_path):
    t = np.linspace(0, 1, 11)
    q = np.stack([np.sin(t), np.cos(t)], axis=1)
    motion = Motion(t, q, q, q)
    following = NextExperiment(motion, 30.0, 2.0, 0.003, 0.24, ("a or b",), 6, ())
    page = Reader(write(found, tmp_path / "next", following))
    assert any("To tell a or b: run next_experiment/trajectory.csv" in x for x in page.text)
    assert any(x.startswith("1. Run next_experiment/trajectory.csv on the arm") for x in page.text)
    rows = (tmp_path / "next" / "next_experiment" / "trajectory.csv").read_text().splitlines()
    assert len(rows) == 1 + len(t)
    record = json.loads((tmp_path / "next" / "diagnosis.json").read_text())
    folder = tmp_path / "next" / record["next_experiment"]
    assert (folder / "design.json").is_file()
    shown = (folder / "report.html").read_text(encoding="utf-8")
    assert shown.count("<iframe srcdoc=") == 1
    assert "To tell a or b." in shown
    assert 'href="next_experiment/report.html"' in (tmp_path / "next" / "report.html").read_text()
