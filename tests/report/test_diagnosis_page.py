"""The page of a diagnosis: what a reader is promised of it."""

import dataclasses
import json
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from oed.diagnosis.diagnose import Diagnosis, diagnose
from oed.diagnosis.discrimination.next_motion import NextExperiment
from oed.diagnosis.inference.answer import Unexplained
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.motion import Motion
from oed.dynamics.torque_model import TorqueModel
from oed.report.diagnosis_report import write_diagnosis
from oed.report.provenance import Provenance
from tests.diagnosis.arm import data_set, stribeck

JOINTS = ("<b>shoulder</b>", "elbow & wrist")
NAMES = ("stribeck", "torque_offset", "nonlinear_viscous")


class Reader(HTMLParser):
    """Collects headings and other text in order, tags, and what refers elsewhere."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.references: list[str] = []
        self.text: list[str] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.references += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_data(self, data: str) -> None:
        if self.tags[-1:] != ["style"] and data.strip():
            self.text.append(data.strip())


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    data = data_set(31, extra=stribeck(1.5, 0.15), repetitions=2)
    return diagnose(data, TorqueModel.standard(data.robot), names=NAMES)


def write(found: Diagnosis, out: Path, following: NextExperiment | None = None) -> str:
    write_diagnosis(
        found,
        following,
        data="<i>bench</i>",
        joints=JOINTS,
        notes=("the log pauses once",),
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
    assert not {"script", "link", "iframe", "object"} & set(page.tags)


def test_names_are_text_and_never_markup(html):
    assert not {"b", "i"} & set(Reader(html).tags)
    for name in (*JOINTS, "<i>bench</i>"):
        assert any(name in text for text in Reader(html).text)


def test_verdict_budget_additions_errors_and_what_is_left_follow_one_another(html, found):
    texts = Reader(html).text
    title, _, headline = texts[1:4]
    assert title == "What the model lacks: <i>bench</i>"
    assert headline.startswith(f"{found.verdict.capitalize()}: stribeck (joint 1)")
    headings = (
        "Torque budget",
        "What each addition does",
        "Errors before and after",
        f"stribeck, joint 1 ({JOINTS[0]})",
        "There, but without a name",
        "Notes on the data",
    )
    places = [texts.index(heading) for heading in headings]
    assert places == sorted(places)


def test_tells_every_effect_of_the_record_with_its_parameters_and_rivals(html, folder):
    record = json.loads((folder / "diagnosis.json").read_text())
    assert record["effects"]
    texts = Reader(html).text
    for effect in record["effects"]:
        assert set(effect["parameters"]) <= set(texts)
        assert {rival["term"] for rival in effect["alternatives"]} <= set(texts)


def test_does_not_say_that_all_is_well_where_something_has_no_name(found, tmp_path):
    strange = Unexplained(1, ("q_1", "q_2"), "f(q_1, q_2)", None)
    left = dataclasses.replace(found, verdict="unexplained", unexplained=(strange,))
    page = Reader(write(left, tmp_path / "left"))
    headline = page.text[3]
    assert headline.startswith("Unexplained")
    assert "something without a name at joint 2 (goes with q_1, q_2)" in headline
    assert "q_1, q_2" in page.text


def test_a_floor_that_held_what_was_found_is_said_to_be_too_high(found, tmp_path):
    def said(page):
        return [text for text in page.text if "the noise is lower" in text]

    assert not said(Reader(write(found, tmp_path / "as_it_is")))
    high = found.noise_floor * np.array([3.0, 1.0])
    page = Reader(write(dataclasses.replace(found, noise_floor=high), tmp_path / "high"))
    assert len(said(page)) == 1
    assert f"At joint 1 ({JOINTS[0]}) less" in said(page)[0]


def test_a_contradiction_by_the_test_recordings_stands_beside_the_verdict(found, tmp_path):
    words = "the test recordings contradict stribeck@1: their error is 3 with it and 2 without"
    page = Reader(write(dataclasses.replace(found, contradicted=(words,)), tmp_path / "against"))
    assert any(words[1:] in text for text in page.text[:6])


def test_hands_on_the_motion_that_tells_alternatives_apart(found, tmp_path):
    t = np.linspace(0, 1, 11)
    q = np.stack([np.sin(t), np.cos(t)], axis=1)
    motion = Motion(t, q, q, q)
    following = NextExperiment(motion, 30.0, 2.0, 0.003, 0.24, ("a or b",), 6, ())
    page = Reader(write(found, tmp_path / "next", following))
    assert any("To tell a or b: run next_experiment/trajectory.csv" in x for x in page.text)
    rows = (tmp_path / "next" / "next_experiment" / "trajectory.csv").read_text().splitlines()
    assert len(rows) == 1 + len(t)
    record = json.loads((tmp_path / "next" / "diagnosis.json").read_text())
    assert (tmp_path / "next" / record["next_experiment"] / "design.json").is_file()
