"""Which additions stay where all of them together raise the error of what was not fitted."""

import pytest

from oed.diagnosis.candidates.accepted import Accepted
from oed.diagnosis.evidence import never_worse as module
from oed.diagnosis.evidence.final_model import fit_final
from oed.diagnosis.evidence.never_worse import never_worse
from oed.diagnosis.search.selected import Selection
from tests.diagnosis.arm import data_set
from tests.diagnosis.shop import shop_of, trial_of

KEYS = [(name, joint) for name in ("torque_offset", "asymmetric_viscous") for joint in (0, 1)]
A, B, C, D = KEYS


@pytest.fixture(scope="module")
def shop():
    return shop_of(data_set(3))


@pytest.fixture
def left(shop, monkeypatch):
    """Which additions stay, by what each wins and which sets cost more than that."""
    found, held_out_rms = module.final_with, module.held_out_rms
    sets, asked = {}, []

    def final_with(shop, chosen):
        final = found(shop, chosen)
        sets[id(final)] = (final, {t.key for t in chosen.chosen})
        return final

    def noted(shop, final, validation):
        asked[:] = [sets[id(final)][1] if id(final) in sets else set()]
        return held_out_rms(shop, final, validation)

    def of(keys, wins, is_dear):
        monkeypatch.setattr(module, "final_with", final_with)
        monkeypatch.setattr(module, "held_out_rms", noted)
        monkeypatch.setattr(module, "costs", lambda *_: is_dear(asked[0]))
        monkeypatch.setattr(module, "rise", lambda *_: -float(sum(wins[k] for k in asked[0])))
        accepted = [Accepted(trial_of(shop, *key), 1e3) for key in keys]
        before = fit_final(shop.baseline, shop.mean, shop.baseline.model)
        selection = Selection.of(shop, accepted, [])
        kept, final = never_worse(shop, selection, shop.validation, before)
        assert (final is before) == (not kept.trials)
        assert len(kept.accepted) + len(kept.refused) == len(keys)
        return {t.key for t in kept.trials}

    return of


def test_all_stay_where_they_cost_nothing(left):
    assert left(KEYS, dict.fromkeys(KEYS, 1), lambda _: False) == set(KEYS)


def test_what_is_dear_goes(left):
    assert left([A, B, C], {A: 2, B: 1, C: 1}, lambda kept: B in kept) == {A, C}


def test_what_holds_by_itself_is_not_lost_beside_what_wins_more_and_is_too_dear(left):
    """One by one the two that win least go first, and in the end the others, too."""
    wins = {A: 1, B: 1, C: 5, D: 5}
    assert left(KEYS, wins, lambda kept: C in kept or D in kept) == {A, B}


def test_what_pays_only_beside_another_is_not_lost_by_being_tried_alone(left):
    assert left([A, B, C], {A: 1, B: 1, C: 1}, lambda kept: len(kept) in {1, 3}) in (
        {A, B},
        {A, C},
        {B, C},
    )


def test_nothing_stays_where_each_is_dear(left):
    assert left([A, B], {A: 1, B: 1}, lambda kept: len(kept) > 0) == set()
