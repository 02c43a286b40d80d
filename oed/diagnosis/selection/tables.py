"""The candidates that are worth a closer look beside a model."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from oed.diagnosis.candidates.candidate import Candidate
from oed.diagnosis.evidence.term import Term
from oed.diagnosis.evidence.views import Views
from oed.diagnosis.numbers import COMPARED, POLISHED
from oed.diagnosis.selection.screen import Scored, evaluate, polish
from oed.diagnosis.selection.table import Line, Table, lay_out, ranked
from oed.parallel_map import parallel_map


@dataclass(frozen=True, eq=False)
class Tables:
    """Score tests of what is alike in all repetitions, and of what is not."""

    alike: Table
    changing: Table

    @classmethod
    def of(cls, views: Views, candidates: Sequence[Candidate]) -> Tables:
        """Lay out all candidates."""
        return cls(
            lay_out(views.means, [c for c in candidates if not c.changes]),
            lay_out(views.every, [c for c in candidates if c.changes]),
        )

    def best(
        self,
        views: Views,
        excluded: frozenset[str],
        most: int = POLISHED,
        keep: Callable[[Line], bool] = lambda _: True,
    ) -> list[Scored]:
        """The names and the smooth terms that are worth most beside a model, polished, best first."""

        def wanted(line: Line) -> bool:
            return line.candidate.label not in excluded and keep(line)

        lines = ranked(self.alike, views.means, wanted)
        lines += ranked(self.changing, views.every, wanted)
        lines.sort(key=lambda own: -own[0][0])
        names = _spread([own for own in lines if own[0][1].candidate.is_named])[:most]
        smooth = [own for own in lines if not own[0][1].candidate.is_named][: most // 2]
        for fitted in (views.means, views.every):
            fitted.projection.span  # noqa: B018 shared by all that are polished

        def rough(lines: list[tuple[float, Line]]) -> Scored | None:
            candidate = lines[0][1].candidate
            fitted = views.showing(candidate)
            starts = (evaluate(candidate, line.values, fitted) for _, line in lines)
            start = next((s for s in starts if s is not None), None)
            return None if start is None else polish(start, fitted, roughly=True)

        asked = [*names, *smooth]
        same = [own[0][1].candidate for own in asked]
        found = _best_first(s for s in parallel_map(rough, asked, same=same) if s is not None)
        worthy = few(found)
        others = [s for s in found if s not in worthy]
        polished = parallel_map(lambda s: polish(s, views.showing(s.candidate)), worthy, same=same)
        return _best_first([*polished, *others])


def _best_first(scored: Iterable[Scored]) -> list[Scored]:
    return sorted(scored, key=lambda s: -s.nats)


def _spread(lines: list[list[tuple[float, Line]]]) -> list[list[tuple[float, Line]]]:
    """Lines of names, best first, those beyond the best few of each place after all others."""
    seen: dict[int | None, int] = {}
    rank = []
    for own in lines:
        joint = own[0][1].candidate.joint
        seen[joint] = seen.get(joint, 0) + 1
        rank.append(seen[joint] > COMPARED)
    return [lines[k] for k in sorted(range(len(lines)), key=lambda k: (rank[k], k))]


def as_term(scored: Scored) -> Term:
    """A scored candidate as part of a model."""
    own, found = scored.candidate, scored.worth
    if own.acts_on_model:
        return Term(own, scored.values, (tuple(found.coefficients.tolist()),))
    penalty = own.precision(len(found.coefficients))
    return Term(own, scored.values, (), None if penalty is None else found.precision)


def few(scored: Sequence[Scored]) -> list[Scored]:
    """The best names, and half as many smooth terms."""
    names = [s for s in scored if s.candidate.is_named][:COMPARED]
    return [*names, *[s for s in scored if not s.candidate.is_named][: COMPARED // 2]]
