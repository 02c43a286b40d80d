"""The page of a diagnosis: what a reader is promised of it."""

import dataclasses
import json
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
from matplotlib.figure import Figure

from oed.diagnosis.candidates.accepted import Refused
from oed.diagnosis.diagnosis import Diagnosis, diagnose
from oed.diagnosis.evidence.estimates import Estimated
from oed.diagnosis.evidence.verdict import Unexplained
from oed.diagnosis.settings import DiagnosisSettings
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.torque_model import TorqueModel
from oed.report.diagnosis_report import draw_figures, write_diagnosis
from oed.report.effect_words import known_parameters
from oed.report.provenance import Provenance
from tests.diagnosis.arm import data_set, stribeck

JOINTS = ("<b>shoulder</b>", "elbow & wrist")
# Few surrogates and names: it is the page that is looked at.
SETTINGS = DiagnosisSettings(
    surrogates=19, bootstrap=20, candidates=("stribeck", "torque_offset", "nonlinear_viscous")
)


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
    data = data_set(0, extra=stribeck(1.0))
    return diagnose(data, TorqueModel.standard(data.robot), SETTINGS)


def write(found: Diagnosis, out, joints=JOINTS) -> str:
    """The page, whose pictures are of one dot: what they show is looked at elsewhere."""
    with patch("oed.report.diagnosis_report.save_figure", dot):
        return write_drawn(found, out, joints)


def dot(figure, stem: Path, formats) -> tuple[Path, ...]:
    file = stem.with_suffix(".png")
    Figure(figsize=(0.01, 0.01)).savefig(file)
    return (file,)


def write_drawn(found: Diagnosis, out, joints=JOINTS) -> str:
    write_diagnosis(
        found,
        None,
        data="<i>bench</i>",
        joints=joints,
        settings=SETTINGS,
        provenance=Provenance.collect(SETTINGS, seed=0),
        out=out,
    )
    return (out / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(found, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("page")
    write_drawn(found, out)
    return out


@pytest.fixture(scope="module")
def html(folder) -> str:
    return (folder / "report.html").read_text(encoding="utf-8")


def with_effect(found: Diagnosis, **changes) -> Diagnosis:
    return dataclasses.replace(
        found, effects=(dataclasses.replace(found.effects[0], **changes), *found.effects[1:])
    )


def with_slide(found: Diagnosis) -> Diagnosis:
    """The same numbers of an arm whose first joint slides."""
    robot = found.before.model.robot
    slide = dataclasses.replace(robot.joints[0], kind="prismatic")
    robot = dataclasses.replace(robot, joints=(slide, *robot.joints[1:]))
    model = dataclasses.replace(found.before.model, robot=robot)
    return dataclasses.replace(found, before=dataclasses.replace(found.before, model=model))


def labels_of(figure) -> list[str]:
    return [text for a in figure.axes for text in (a.get_title(loc="left"), a.get_xlabel())]


def test_needs_no_other_file(html):
    page = Reader(html)
    assert len(page.references) == len(("proof", "additions", "dependence", "spectrum"))
    assert all(reference.startswith("data:image/") for reference in page.references)
    assert not {"script", "link", "iframe", "object"} & set(page.tags)


def test_names_are_text_and_never_markup(html):
    assert not {"b", "i"} & set(Reader(html).tags)
    for name in (*JOINTS, "<i>bench</i>"):
        assert any(name in text for text in Reader(html).text)


def test_the_verdict_comes_first(html, found):
    title, _, headline = Reader(html).text[1:4]
    assert title == "What the model lacks: <i>bench</i>"
    assert headline.startswith(f"{found.verdict.capitalize()}: stribeck on joint 1")


def test_tells_every_effect_of_the_record_with_its_parameters_and_rivals(html, folder):
    record = json.loads((folder / "diagnosis.json").read_text())
    assert record["effects"]
    texts = Reader(html).text
    for effect in record["effects"]:
        label = f"joint {effect['joint'] + 1} ({JOINTS[effect['joint']]})"
        assert f"Found: {effect['name']} on {label}" in texts
        assert set(effect["parameters"]) <= set(texts)
        assert {rival["name"] for rival in effect["alternatives"]} <= set(texts)


def test_tells_what_has_no_name_and_what_was_turned_down(found, tmp_path):
    strange = Unexplained(1, ("q_1", "q_2"), 0.25, "f(q_1, q_2)", stands_in=False)
    refused = Refused("joint_spring", 1, 12.3, "pays for nothing")
    page = Reader(
        write(
            dataclasses.replace(
                found, verdict="unexplained", unexplained=(strange,), refused=(refused,)
            ),
            tmp_path,
        )
    )
    assert {"f(q_1, q_2)", "25%", "joint_spring", "pays for nothing"} <= set(page.text)
    # Read as one of the four verdicts, as the record has it.
    assert page.text[3].startswith("Unexplained: stribeck on joint 1")
    assert page.text[3].endswith("found; something without a name is left on joint 2")


@pytest.mark.parametrize("roles", [(), ("validation",), ("test",), ("validation", "test")])
def test_speaks_of_the_recordings_that_there_are(roles, found, tmp_path):
    kept = tuple(p for p in found.proof if p.role in ("estimation", *roles))
    html = write(dataclasses.replace(found, proof=kept), tmp_path)
    for role in ("validation", "test"):
        assert (f"{role} recordings" in html) == (role in roles)
    assert ("none was kept" in html) == (not roles)


def test_what_uncertain_parameters_let_expect_is_no_mistake_in_the_files(found, tmp_path):
    proof = tuple(
        dataclasses.replace(p, after=30.0 * found.noise_floor) if p.role == "validation" else p
        for p in found.proof
    )
    far = dataclasses.replace(found, proof=proof, unexplained=())
    html = write(far, tmp_path)
    assert "a mistake in the files" in html
    assert "so uncertain" not in html
    html = write(dataclasses.replace(far, expected=np.full(2, 20.0)), tmp_path)
    assert "a mistake in the files" not in html
    assert "so uncertain" in html
    assert "is not what happens" not in html


def test_says_where_nothing_was_found(found, tmp_path):
    nothing = dataclasses.replace(found, verdict="nothing found", effects=())
    page = Reader(write(nothing, tmp_path))
    assert page.text[3] == "Nothing found"
    assert "Found: nothing" in page.text


def test_does_not_say_that_all_is_well_where_something_has_no_name(found, tmp_path):
    strange = Unexplained(1, ("q_1", "q_2"), 0.25, "f(q_1, q_2)", stands_in=False)
    bare = dataclasses.replace(found, verdict="unexplained", effects=(), unexplained=(strange,))
    page = Reader(write(bare, tmp_path))
    assert "Found: no name" in page.text
    assert "Found: nothing" not in page.text


@pytest.mark.parametrize("name", ["torque_offset", "time_delay", "nonlinear_viscous"])
def test_says_what_a_name_cannot_be_told_from(name, found, tmp_path):
    html = unescape(write(renamed(found, name), tmp_path))
    entry = CATALOGUE[name]
    assert all(words in html for words in entry.equivalent)
    assert ("Cannot be told" in html) == bool(entry.equivalent)
    assert f"Easily confused, on a poor motion, with: {', '.join(entry.page.confused_with)}" in html


@pytest.mark.parametrize(
    ("value", "words"), [(0.0, "at its bound, unknown"), (0.4, "unknown between 0 and 1")]
)
def test_calls_unknown_what_the_data_do_not_say(value, words, found, tmp_path):
    unknown = Estimated("tail", value, 1 / np.sqrt(12), "1")
    parameters = (*found.effects[0].parameters[:-1], unknown)
    assert found.effects[0].parameters[-1].name == "tail"
    page = Reader(write(with_effect(found, parameters=parameters), tmp_path))
    assert page.text.count(words) == 1
    assert f"{unknown.std:.3g}" not in page.text
    record = json.loads((tmp_path / "diagnosis.json").read_text())["effects"][0]["parameters"]
    assert record["tail"] == {"value": value, "std": unknown.std, "unit": "1", "note": words}
    assert "note" not in record["Fs_1"]


def test_a_known_shape_keeps_its_standard_deviation(found):
    joints = found.before.model.robot.joints
    known = known_parameters(found.effects[0], found.shop.context, joints)
    speed = next(p for p in known if p.name == "speed")
    assert (speed.note, speed.uncertainty) == (None, speed.std)


@pytest.mark.parametrize(("end", "words"), [("lower", "at its least"), ("upper", "at its largest")])
def test_a_known_shape_at_its_bound_says_so(end, words, found):
    effect, context = found.effects[0], found.shop.context
    shapes = CATALOGUE[effect.name].shapes_for(context, effect.trial.target)
    (place,) = [k for k, p in enumerate(effect.parameters) if p.name == "speed"]
    bound = getattr(next(s for s in shapes if s.name == "speed"), end)
    speed = dataclasses.replace(effect.parameters[place], value=bound)
    parameters = (*effect.parameters[:place], speed, *effect.parameters[place + 1 :])
    moved = dataclasses.replace(effect, parameters=parameters)
    known = known_parameters(moved, context, found.before.model.robot.joints)
    assert known[place].note == words


def test_a_sliding_joint_has_forces_and_metres(found, tmp_path):
    slide = with_slide(found)
    known = known_parameters(slide.effects[0], slide.shop.context, slide.before.model.robot.joints)
    assert {"Fs_1": "N", "speed": "m/s"}.items() <= {p.name: p.unit for p in known}.items()
    figures = draw_figures(slide, ("slide", "elbow"))
    names = ("proof", "dependence", "additions")
    proof, dependence, additions = (labels_of(figures[name]) for name in names)
    assert {"joint 1 (slide) [N]", "joint 2 (elbow) [N m]"} <= set(proof)
    assert "velocity of joint 1 [m/s]" in dependence
    assert "position of joint 2 [rad]" in dependence
    assert additions[:2] == ["joint 1: stribeck", "velocity of joint 1 [m/s]"]
    assert figures["additions"].axes[0].get_ylabel() == "[N]"


def test_where_nothing_was_added_no_addition_is_drawn(found, tmp_path):
    bare = dataclasses.replace(found, effects=(), unexplained=(), contributions=())
    assert "additions" not in draw_figures(bare, JOINTS)
    assert "What each addition does" not in Reader(write(bare, tmp_path)).text


def test_the_spectrum_shows_the_edge_of_the_band_and_the_noise_floor(found):
    for j, panel in enumerate(draw_figures(found, JOINTS)["spectrum"].axes):
        lines = {line.get_label(): line for line in panel.lines}
        assert np.all(np.asarray(lines["edge of the analysis band"].get_xdata()) == found.cutoff)
        level = np.asarray(lines["noise floor"].get_ydata())
        np.testing.assert_allclose(level**2 * found.cutoff, found.noise_floor[j] ** 2)


def test_every_panel_of_a_dependence_names_a_unit(found):
    labels = labels_of(draw_figures(found, JOINTS)["dependence"])
    assert all(label.endswith("]") for label in labels)


def renamed(found: Diagnosis, name: str) -> Diagnosis:
    """The first effect under another name, its shapes at their defaults."""
    shapes = CATALOGUE[name].shapes
    return with_effect(
        found,
        name=name,
        parameters=tuple(Estimated(s.name, s.default, 0.0, s.unit) for s in shapes),
        trial=dataclasses.replace(
            found.effects[0].trial, name=name, values=tuple(s.default for s in shapes)
        ),
    )
