"""From a data set to a problem: bands, noise, rows, candidates."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

from oed.diagnosis.candidates.candidate import SmoothCandidate
from oed.diagnosis.evidence.columns import white_model
from oed.diagnosis.evidence.nuisances import nuisances
from oed.diagnosis.numbers import EFFECTS_PER_JOINT, LEAST_EFFECTS
from oed.diagnosis.problem import Problem, named_candidates
from oed.diagnosis.rows.white_rows import WhiteRows
from oed.dynamics.effects.catalogue import CATALOGUE, CatalogueEntry, Context, Drives
from oed.dynamics.effects.entries.measurement import standing
from oed.dynamics.torque_model import TorqueModel
from oed.dynamics.velocity_sign import with_widths
from oed.estimation.calibration import NOTHING, Calibration, calibrate
from oed.estimation.dissipation import check_dissipation, driven_joints
from oed.estimation.known_torque import KnownTorque
from oed.estimation.noise_floor.baseline import Baseline, find_baseline
from oed.estimation.noise_floor.linear_fit import LinearFit, fit_model
from oed.estimation.noise_floor.smooth_terms import ALL_PAIRED, terms_alone, terms_together
from oed.estimation.noise_floor.weighted_rows import weigh
from oed.estimation.reach import find_reach
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.excerpts import excerpts
from oed.experiment.preparation.mean_repetition import mean_of_repetitions
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.prepared import Prepared
from oed.experiment.preparation.settings import ProcessingSettings, choose_settings

# Of the columns of one fit: with its temporaries and the fits beside it, a gigabyte.
FIT_BYTES = 45_000_000
COLUMNS_PER_JOINT = 20  # base model, nuisances and terms of an arm of six joints are 120


@dataclass(frozen=True)
class Sealed:
    """All recordings, those for the test among them: for the report alone.

    Attributes:
        every: The recordings, prepared, without the torque that is known.
        before: The base model's estimate and its errors, as `oed identify` has them.
        baseline: Gives the noise and how certain a row's direction is.
    """

    every: tuple[Prepared, ...]
    before: Calibration
    baseline: Baseline

    @property
    def floor(self) -> Float[ndarray, " joints"]:
        """(n,) deviation of the noise [N m]."""
        return self.baseline.floor.deviation

    @property
    def source(self) -> str:
        """Where the noise was read off."""
        return self.baseline.floor.source

    def weights(self, prepared: Sequence[Prepared]) -> list[Float[ndarray, "_ joints"]]:
        """Share of noise in the variance of each valid row's error."""
        return self.baseline.noise_share(prepared)


def pose(
    dataset: DataSet,
    model: TorqueModel,
    settings: ProcessingSettings | None = None,
    *,
    catalogue: Mapping[str, CatalogueEntry] = CATALOGUE,
    names: Sequence[str] | None = None,
    most: int | None = None,
    known: KnownTorque = NOTHING,
    noise_of: TorqueModel | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> tuple[Problem, Sealed, tuple[str, ...]]:
    """Lay out what a search may look at, and seal the rest.

    Args:
        dataset: Recordings with roles.
        model: The base model.
        settings: How recordings are processed; chosen from them if None.
        catalogue: Effects that may be named.
        names: Of these, those that are tried; all if None.
        most: Terms that may be added.
        known: Torque that was found before and is taken off.
        noise_of: Model beside which the noise is read off; `model` if None.
        say: Receives lines of progress.

    Returns:
        The problem, without any test recording; all recordings for the report; notes on the data.

    Raises:
        ValueError: If there is no estimation recording, or one is too short.
        OedError: If a joint stands still, or friction drives every joint.
    """
    if not dataset.estimation:
        raise ValueError(
            f"data set {dataset.name!r} has no recording with role estimation: give that role to one in "
            "its dataset.toml"
        )
    dataset.check_moves()
    settings = settings or choose_settings(dataset.recordings)
    prepared = known.taken_off(prepare(dataset.recordings, settings), model)
    say(f"analysis band up to {prepared[0].band.cutoff:.3g} Hz")
    estimation, validation = _looked_at(prepared, say)
    model = standing(model)
    before = calibrate(dataset, model, settings, known=known, noise_of=noise_of)
    # Of recordings that are too short it raises what is wrong with them.
    baseline = before.baseline or find_baseline(model, estimation)
    rows = WhiteRows.of(weigh((*estimation, *validation), baseline.floor.noise, baseline.coulomb))
    first = fit_model(
        baseline.model, baseline.columns, weigh(estimation, baseline.floor.noise, baseline.coulomb)
    )
    ratio = dataset.drive.gear_ratio
    drives = Drives(
        None if ratio is None else tuple(float(x) for x in ratio),
        of_motors=dataset.torque != "measured",
    )
    context = Context.of(
        baseline.model,
        first.full_parameters(),
        [p.motion for p in estimation],
        drives,
        later=[p.motion for p in validation],
        ordered=len(estimation) < 2 or not estimation[0].laid or any(p.period for p in estimation),
        cut=prepared[0].band.cut / prepared[0].band.rate,
    )
    n = model.robot.n
    # Over all that is fitted in the end: a curve that ends sooner cannot follow the rest.
    looked_at = (*estimation, *validation)
    smooth = terms_alone(looked_at, n)
    if n <= ALL_PAIRED:
        smooth += terms_together(looked_at, n, range(n))
    repeated = any(p.period is not None for p in rows.prepared)
    problem = Problem(
        rows,
        baseline.model,
        with_widths(baseline.model, baseline.least_widths),
        baseline.columns,
        _precision_of_untold(baseline.model, baseline.columns, rows),
        context,
        baseline.floor.deviation,
        baseline.floor.source == "repetitions",
        named_candidates(catalogue, tuple(names or catalogue), context),
        tuple(SmoothCandidate(t) for t in smooth),
        max(EFFECTS_PER_JOINT * n, LEAST_EFFECTS) if most is None else most,
        nuisances(rows, context, dataset.estimation, repeated=repeated),
    )
    pairs = [mean_of_repetitions(p) for p in (*estimation, *validation)]
    if any(count > 1 for _, count in pairs):
        mean = tuple(p for p, _ in pairs)
        scales = tuple(1 / float(np.sqrt(count)) for _, count in pairs)
        few = WhiteRows.of(weigh(mean, baseline.floor.noise, baseline.coulomb, scales))
        own = nuisances(few, context, dataset.estimation, repeated=True)
        means = dataclasses.replace(problem, rows=few, nuisances=own)
        problem = dataclasses.replace(problem, means=means)
    return problem, Sealed(prepared, before, baseline), _sign_notes(first, estimation, dataset.name)


def _precision_of_untold(
    model: TorqueModel, columns: Int[ndarray, " base"], rows: WhiteRows
) -> Float[ndarray, "base base"]:
    """Prior of base parameters that holds at zero what the fitted rows do not carry to the others.

    As `oed identify` does, but an error that nobody can see is as large as noise: what the base model
    leaves may be what it lacks, and would forbid the parameters that are right beside it.
    """
    white = white_model(model, columns, rows)

    def by_row(where: Bool[ndarray, " rows"]) -> Float[ndarray, "_ base"]:
        return white[:, where].transpose(1, 0, 2).reshape(-1, len(columns))

    usual = np.sqrt(np.mean(rows.torque[:, rows.fitted] ** 2, axis=1))
    seen, asked = by_row(rows.fitted), by_row(rows.held_out)
    held = find_reach(seen, [asked], np.ones(rows.joints), usual).prior(len(seen)).factor
    return held.T @ held


def _looked_at(
    prepared: Sequence[Prepared], say: Callable[[str], None]
) -> tuple[tuple[Prepared, ...], tuple[Prepared, ...]]:
    """Recordings for estimation and for validation, or stretches of them: as many rows as fits can hold."""
    own = [tuple(p for p in prepared if p.role == role) for role in ("estimation", "validation")]
    joints = prepared[0].torque.shape[1]
    most = FIT_BYTES // (8 * joints * COLUMNS_PER_JOINT * joints)
    counts = [sum(p.rows for p in each) for each in own]
    total = sum(counts)
    estimation, validation = (
        excerpts(each, most * count // max(total, 1))
        for each, count in zip(own, counts, strict=True)
    )
    kept = sum(p.rows for p in (*estimation, *validation))
    if kept < total:
        say(
            f"of {total} rows {kept} are looked at, in stretches spread evenly: as many as two gigabytes of "
            "memory hold; errors are those of all rows"
        )
    return estimation, validation


def _sign_notes(first: LinearFit, prepared: Sequence[Prepared], name: str) -> tuple[str, ...]:
    """What friction says of the torques' signs, joint by joint; refused where all are wrong."""
    names = (p.name for p in first.model.parameters)
    friction = dict(zip(names, first.full_parameters().tolist(), strict=True))
    dq = np.concatenate([p.band.apply(p.motion.dq) for p in prepared])
    torque = np.concatenate([p.torque for p in prepared])
    check_dissipation(friction, dq, torque, name)
    joints = first.model.robot.joint_names
    return tuple(
        f"{joints[j]}: in the base model friction drives it instead of braking it "
        f"(Fc_{j + 1} = {friction.get(f'Fc_{j + 1}', 0.0):.3g}): is the sign of tau_{j + 1} opposite "
        f"to that of q_{j + 1}, or the order of the columns another?"
        for j in driven_joints(friction, dq, torque)
    )
