"""What is promised of a whole diagnosis, on small data sets."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

from oed.diagnosis.diagnose import diagnose
from oed.diagnosis.evidence.moments import correlated_rows
from oed.diagnosis.inference.answer import answer
from oed.diagnosis.inference.covariance import parameter_covariance
from oed.diagnosis.selection.screen import evaluate
from oed.diagnosis.selection.substitutes import Substitute, preferred
from oed.diagnosis.selection.tables import as_term
from oed.dynamics.effects import TorqueOffset
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import widths_of
from oed.estimation.calibration import calibrate
from oed.experiment.preparation.settings import choose_settings
from oed.export.found_models import of_diagnosis
from oed.export.model_file import load_model, write_model
from oed.report.provenance import Provenance
from tests.diagnosis.arm import COULOMB, data_set, stribeck
from tests.paths import REPO

FEW = ("stribeck", "torque_offset", "joint_spring", "rotor_inertia", "nonlinear_viscous")


def _diagnose(dataset, **options):
    return diagnose(dataset, TorqueModel.standard(dataset.robot), **{"names": FEW, **options})


@pytest.fixture(scope="module")
def found_stribeck():
    return _diagnose(data_set(31, extra=stribeck(1.5, 0.15), repetitions=2))


def test_names_nothing_where_nothing_is_missing():
    found = _diagnose(data_set(32, repetitions=2))
    assert found.effects == ()
    assert found.verdict == "nothing found"


def test_finds_what_was_put_in_and_says_its_size(found_stribeck):
    (effect,) = found_stribeck.effects
    assert (effect.name, effect.joint) == ("stribeck", 0)
    assert effect.probability > 0.95
    sizes = {p.name: p for p in effect.parameters}
    size = sizes["Fs_1"]
    assert size.std is not None
    assert abs(size.value - 1.5) < 4 * size.std
    assert abs(sizes["speed"].value - 0.15) < 0.1


def test_the_model_that_is_handed_on_turns_friction_as_the_base_model_does():
    """Rows of a reversal are uncertain to the search; to an estimate they tell how friction turns."""
    width = 0.01

    def softer_and_offset(q, dq, ddq):
        return COULOMB * (np.tanh(dq / width) - np.sign(dq)) + np.array([0.0, 0.4])

    dataset = data_set(35, extra=softer_and_offset, repetitions=2)
    found = _diagnose(dataset)
    assert [(e.name, e.joint) for e in found.effects] == [("torque_offset", 1)]
    whole = TorqueModel.standard(dataset.robot).with_effects(TorqueOffset(1))
    widths = widths_of(calibrate(dataset, whole, choose_settings(dataset.recordings)).model)
    assert widths_of(found.after.model) == widths
    assert widths == pytest.approx([width, width], rel=1.0)


def test_a_constant_is_named_though_any_curve_over_time_holds_one():
    offset = data_set(
        34, extra=lambda q, *_: np.stack([0 * q[:, 0], 0 * q[:, 0] + 0.4], axis=1), repetitions=3
    )
    found = _diagnose(offset)
    assert [(e.name, e.joint) for e in found.effects] == [("torque_offset", 1)]
    (size,) = found.effects[0].parameters
    assert size.std is not None
    assert abs(size.value - 0.4) < 4 * size.std


def test_a_curve_that_is_flat_says_nothing_against_a_constant_and_a_bent_one_does():
    offset = data_set(
        41, extra=lambda q, *_: np.stack([0 * q[:, 0] + 2.0, 0 * q[:, 0]], axis=1), repetitions=1
    )
    selected = _diagnose(offset).selected
    (own,) = selected.judged
    curve = next(c for c in own.rest.problem.smooth if c.label == "f(q_1)[11]@1")
    scored = evaluate(curve, (), own.rest.means)
    assert scored is not None
    for is_same, count in ((True, 1), (False, 0)):
        both = (
            Substitute(own.term, own.worth.nats, is_same=True, price=0.0),
            Substitute(as_term(scored), own.worth.nats - 0.5, is_same, price=0.0),
        )
        found = answer(dataclasses.replace(selected, substitutes=(both,)))
        assert len(found.effects) == count
        assert all(e.probability > 0.95 for e in found.effects)


def test_a_curve_that_gives_the_torque_of_a_name_is_no_rival_of_it(found_stribeck):
    (own,) = found_stribeck.selected.judged
    curve = next(c for c in own.rest.problem.smooth if c.joint == 0)
    scored = evaluate(curve, (), own.rest.means)
    assert scored is not None
    bent = as_term(scored)
    for is_same in (True, False):
        name = Substitute(own.term, own.worth.nats, is_same=True, price=1.0)
        rival = Substitute(bent, own.worth.nats + 5.0, is_same, price=9.0)
        assert preferred(name, (rival, name)) is (None if is_same else rival)
        # The same where the curve came first.
        first, other = (
            dataclasses.replace(rival, is_same=True),
            dataclasses.replace(name, is_same=is_same),
        )
        assert preferred(first, (first, other)) is (other if is_same else None)


def test_other_shapes_of_a_name_are_that_name_and_another_place_is_open(found_stribeck):
    selected = found_stribeck.selected
    (own,), ((first, *_),) = selected.judged, selected.substitutes
    names = selected.views.problem.names
    for label, is_open in (("stribeck@1", False), ("stribeck@2", True)):
        term = dataclasses.replace(own.term, candidate=next(c for c in names if c.label == label))
        rival = Substitute(term, own.worth.nats - 0.5, is_same=False, price=first.price)
        found = answer(dataclasses.replace(selected, substitutes=((first, rival),)))
        (effect,) = found.effects
        assert effect.is_open is is_open
        assert (effect.probability > 0.95) is not is_open


def test_of_what_gives_the_same_torque_the_more_probable_before_data_is_preferred(found_stribeck):
    ((first, *_),) = found_stribeck.selected.substitutes
    term = dataclasses.replace(first.term)
    plain = Substitute(term, first.nats - 0.5, is_same=True, price=first.price - 1.0)
    assert preferred(first, (first, plain)) is plain
    for changed in (
        {"is_same": False},
        {"nats": first.nats - 1.5},
        {"price": first.price},
    ):
        assert preferred(first, (first, dataclasses.replace(plain, **changed))) is None
    better = dataclasses.replace(plain, nats=first.nats + 1.5, price=first.price + 9.0)
    assert preferred(first, (better, first)) is better


def test_is_handed_on_as_a_model_that_predicts_the_same(found_stribeck, tmp_path):
    provenance = Provenance.collect(CATALOGUE["stribeck"].page, seed=0)
    model = of_diagnosis(found_stribeck, "arm", provenance)
    again = load_model(write_model(model, tmp_path / "model.json"))
    after, motion = found_stribeck.after, found_stribeck.selected.views.every.problem.rows.prepared
    motion = motion[0].motion[:500]
    assert again.torque(motion.q, motion.dq, motion.ddq, t=motion.t) == pytest.approx(
        dataclasses.replace(after.model, measurement=()).torque(
            after.parameters, dataclasses.replace(motion, averaged=False)
        ),
        rel=1e-12,
    )
    assert [s.name for s in again.shapes[-1]] == ["speed", "exponent", "tail"]


@pytest.mark.parametrize("names", [("stribeck",), ("rotor_inertia",)])
def test_a_second_round_starts_with_what_the_first_handed_on(names, tmp_path):
    """With a name, whose numbers may be refitted, and without one: a curve that stays as it is."""
    dataset = data_set(31, extra=stribeck(1.5, 0.15), repetitions=2)
    first = _diagnose(dataset, names=names)
    assert bool(first.effects) == (names == ("stribeck",))
    assert first.selected.views.terms
    provenance = Provenance.collect(CATALOGUE["stribeck"].page, seed=0)
    write_model(of_diagnosis(first, "arm", provenance), tmp_path / "model.json")
    started = load_model(tmp_path / "model.json")
    model, known = started.to_estimate()
    assert bool(known.effects) != bool(first.effects)
    second = diagnose(
        dataset,
        model,
        names=names,
        most=0,
        parameters=started.parameters_of(model),
        known=known,
        noise_of=TorqueModel.standard(dataset.robot),
    )
    assert second.noise_floor == pytest.approx(first.noise_floor, rel=1e-9)
    for one, other in zip(first.errors, second.errors, strict=True):
        assert other.before == pytest.approx(one.after, rel=1e-9)
    motion = first.selected.views.every.problem.rows.prepared[0].motion
    again = of_diagnosis(second, "arm", provenance, started)
    there = started.torque_model.torque(started.parameters, motion)
    assert again.torque_model.torque(again.parameters, motion) == pytest.approx(there, rel=1e-9)
    assert sum(map(len, again.shapes)) == sum(map(len, started.shapes))


def test_names_are_those_that_were_judged_though_the_model_is_fitted_again(found_stribeck):
    selected = found_stribeck.selected
    moved = tuple(dataclasses.replace(term) for term in selected.views.terms)
    again = dataclasses.replace(selected, views=selected.views.grown(moved, "all"))
    labels = [(e.name, e.joint, e.probability) for e in found_stribeck.effects]
    assert [(e.name, e.joint, e.probability) for e in answer(again).effects] == labels


def test_covariance_is_the_textbooks_by_blocks(found_stribeck):
    whole = found_stribeck.selected.views.every
    projection, rows = whole.projection, whole.problem.rows
    used = projection.used
    blocks = rows.blocks(max(correlated_rows(whole, j, used) for j in range(2)))[used]
    X = projection.columns[:, used] * projection.weights[:, None, None]
    left = projection.residual[:, used] * projection.weights[:, None]
    bread = np.linalg.inv(np.einsum("jua,jub->ab", X, X))
    scores = [
        np.einsum("jua,ju->a", X[:, blocks == b], left[:, blocks == b]) for b in np.unique(blocks)
    ]
    expected = bread @ np.transpose(scores) @ np.array(scores) @ bread
    found = parameter_covariance(whole)
    # Nuisances stand between the base model's columns and those of the terms.
    (place,) = whole.places
    kept = [*range(len(whole.columns)), *range(place.start, place.stop)]
    assert np.diag(found)[np.diag(found) > 0] == pytest.approx(np.diag(expected)[kept], rel=1e-4)


def test_nothing_is_looked_for_when_the_time_is_over():
    said = []
    found = _diagnose(
        data_set(31, extra=stribeck(1.5, 0.15), repetitions=2), budget=0.0, say=said.append
    )
    assert found.effects == ()
    assert any("its 0 s of CPU time were over" in note for note in found.notes)
    assert not any(line.startswith("+") for line in said)
    explained = next(i for i, line in enumerate(said) if "in noise floors; nats" in line)
    assert explained < next(i for i, line in enumerate(said) if " shapes of " in line)
    assert {e.role for e in found.errors} == {"estimation", "validation", "test"}


def test_budget_adds_up_to_the_torque(found_stribeck):
    budget, errors = found_stribeck.budget, found_stribeck.errors
    held = next(e for e in errors if e.role == budget.role)
    assert budget.role == "validation"
    assert budget.left == pytest.approx(held.after, rel=1e-6)
    (own,) = (s for s in budget.shares if s.label == "stribeck@1")
    assert own.rms[1] == 0
    assert own.rms[0] > found_stribeck.noise_floor[0] / 4


def test_test_recordings_only_report(found_stribeck):
    dataset = data_set(31, extra=stribeck(1.5, 0.15), repetitions=2)
    against = tuple(
        dataclasses.replace(r, tau=r.tau - 2 * stribeck(1.5, 0.15)(r.q, _rate(r), None))
        if r.role == "test"
        else r
        for r in dataset.recordings
    )
    found = _diagnose(dataclasses.replace(dataset, recordings=against))
    assert [(e.name, e.joint) for e in found.effects] == [("stribeck", 0)]
    before, after = found_stribeck.effects[0].parameters, found.effects[0].parameters
    assert [p.value for p in before] == [p.value for p in after]
    (words,) = found.contradicted
    assert words.startswith("the test recordings contradict stribeck@1")
    assert found_stribeck.contradicted == ()


def _rate(recording):
    return np.gradient(recording.q, recording.t, axis=0)


def test_an_unknown_name_is_refused():
    with pytest.raises(ValueError, match="there is no effect"):
        _diagnose(data_set(32, repetitions=2), names=("sticktion",))


def test_nothing_downstream_asks_which_effect_it_is():
    words = "|".join(sorted(set(CATALOGUE) - {"capped_drag"}))
    for file in sorted((REPO / "oed" / "diagnosis").rglob("*.py")):
        code = re.sub(r'"""[\s\S]*?"""|#.*', "", Path(file).read_text(encoding="utf-8"))
        assert not re.search(rf"\b({words})\b", code), file
        assert not re.search(r"isinstance\(\w*effect\w*, ", code), file


@pytest.mark.parametrize("repetitions", [1, 2])
def test_the_base_model_has_the_numbers_of_an_identification(repetitions):
    """One log, one preparation: a reader finds the same floor and the same errors on both pages."""
    dataset = data_set(35, repetitions=repetitions, step=2e-4)
    model = TorqueModel.standard(dataset.robot)
    plain = calibrate(dataset, model, choose_settings(dataset.recordings))
    found = _diagnose(dataset, names=("stribeck",), most=0)
    assert found.noise_floor == pytest.approx(plain.noise_floor, rel=1e-12)
    by_role = {str(role): validation for role, validation in plain.validation.items()}
    for errors in found.errors:
        validation = by_role[errors.role]
        assert errors.before == pytest.approx(validation.rms, rel=1e-6)
        assert errors.before / errors.torque == pytest.approx(validation.relative_rms, rel=1e-6)
