"""The study of coverage: what its methods judge, and what tells its conditions apart."""

import dataclasses

from studies import coverage


def test_methods_judge_the_same_estimates_and_every_condition_has_its_own() -> None:
    config = dataclasses.replace(coverage.SMOKE, runs=1, noises=(coverage.Noise("white"),) * 2)
    cases = coverage.cases_of(config)
    methods = len(config.methods)
    assert len({case.condition for case in cases[:methods]}) == 1
    first, second = (coverage.simulate(case.condition)[0][0] for case in cases[::methods])
    assert first.shape == second.shape == (480, 8)
    assert (first != second).any()


def test_every_line_has_a_key_of_its_own() -> None:
    cases = coverage.cases_of(coverage.Config())
    assert len({case.key for case in cases}) == len(cases) == 24
