"""Terms are said in words of the field, whatever they are made of."""

import pytest

from oed.diagnosis.candidates.candidate import NamedCandidate, SmoothCandidate
from oed.dynamics.effects.arguments import Factor, Loop, VaryingInertia
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.effects.coordinates import Coordinate
from oed.dynamics.effects.smooth_term import SmoothTerm
from oed.estimation.noise_floor.smooth_terms import terms_alone, terms_together
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.settings import choose_settings
from oed.report.term_words import TermWords, in_words, term_words
from tests.diagnosis.arm import data_set


def over(kind: str, joint: int = 0, pieces: int = 8) -> Coordinate:
    return Coordinate(kind, joint, -1.0, 1.0, pieces)


@pytest.mark.parametrize(
    ("term", "said"),
    [
        (
            SmoothTerm(1, (over("q", 1),), direction=1),
            "joint 2: friction that depends on its position (a free curve over q_2, 11 coefficients)",
        ),
        (
            SmoothTerm(1, (over("q", 0, 4), over("dq", 1, 4))),
            (
                "joint 2: torque that depends on its velocity and the position of joint 1 (a free surface over "
                "q_1 and dq_2, 49 coefficients)"
            ),
        ),
        (
            SmoothTerm(0, (VaryingInertia(over("q", 0)),)),
            "joint 1: inertia that varies with its position (a free curve over q_1, 11 coefficients)",
        ),
        (
            SmoothTerm(0, (over("q", 1), Factor("dq", 0))),
            (
                "joint 1: viscous friction that varies with the position of joint 2 (a free curve over q_2, 11 "
                "coefficients)"
            ),
        ),
        (
            SmoothTerm(0, (over("q", 0), Factor("ddq", 1))),
            (
                "joint 1: torque proportional to the acceleration of joint 2, by a factor that varies with its "
                "position (a free curve over q_1, 11 coefficients)"
            ),
        ),
        (
            SmoothTerm(0, (Loop(0, 0.01, 0.1, 6),)),
            (
                "joint 1: torque that depends on its last reversals (hysteresis) (a free curve over loops of "
                "q_1, 6 coefficients)"
            ),
        ),
        (
            SmoothTerm(0, (over("q", 1),), direction=1),
            (
                "joint 1: torque that turns with the direction of joint 2 and depends on the position of joint 2 "
                "(a free curve over q_2, 11 coefficients)"
            ),
        ),
        (
            SmoothTerm(2, (over("time"),), direction=2),
            "joint 3: friction that depends on time (a free curve over time, 11 coefficients)",
        ),
    ],
)
def test_a_free_term_is_said_from_what_it_is_made_of(term: SmoothTerm, said: str) -> None:
    assert term_words(SmoothCandidate(term)).whole == said


def test_a_name_stays_as_the_catalogue_has_it() -> None:
    said = {
        target: term_words(NamedCandidate(CATALOGUE[name], target))
        for name, target in (
            ("stribeck", 1),
            ("motor_coupling", (2, 0)),
            ("gravity_direction", None),
        )
    }
    assert said[1].whole == "joint 2: stribeck"
    assert said[2, 0].whole == "joint 3: motor_coupling from joint 1"
    assert said[None].in_sentence == "gravity_direction (arm)"


def test_no_two_terms_of_a_search_are_said_alike_and_none_by_its_label() -> None:
    data = data_set(31, repetitions=2)
    prepared = prepare(data.recordings, choose_settings(data.recordings))
    terms = (*terms_alone(prepared, 2), *terms_together(prepared, 2, range(2)))
    said: dict[str, str] = {}
    for term in terms:
        candidate = SmoothCandidate(term)
        words = term_words(candidate).whole
        assert not [sign for sign in ("f(", "sgn", "@", "[") if sign in words]
        assert said.setdefault(words, candidate.label) == candidate.label
    assert len(said) == len({SmoothCandidate(t).label for t in terms}) > 50


def test_a_line_that_says_the_joint_does_not_say_it_twice() -> None:
    words = TermWords("joint 2", "stribeck")
    assert words.at(1) == "stribeck"
    assert words.at(0) == "joint 2: stribeck"


def test_in_a_sentence_the_longer_of_two_labels_counts() -> None:
    words = {
        "coupling@1": TermWords("joint 1", "coupling"),
        "coupling@1<2": TermWords("joint 1", "coupling from joint 2"),
    }
    said = in_words("coupling@1<2 or coupling@1", words)
    assert said == "coupling from joint 2 (joint 1) or coupling (joint 1)"
