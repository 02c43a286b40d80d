"""A diagnosis up to its search, for tests of the parts of the search."""

from oed.diagnosis.baseline.baseline import find_baseline
from oed.diagnosis.data.prepare import prepare
from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import catalogue_trial
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.torque_model import TorqueModel


def shop_of(dataset, *, held=True, **settings):
    """Where terms for a data set are tried, with its validation recordings if `held`."""
    chosen = DiagnosisSettings(**settings)
    prepared = prepare(dataset.recordings, chosen)
    own, validation = (
        tuple(p for p in prepared if p.role == role) for role in ("estimation", "validation")
    )
    baseline = find_baseline(TorqueModel.standard(dataset.robot), own)
    return Workshop(baseline, own, validation if held else (), chosen)


def trial_of(shop, name, joint, values=()):
    """An effect of the catalogue with these shapes, those left out at their defaults."""
    entry = CATALOGUE[name]
    values = (*values, *(shape.default for shape in entry.shapes[len(values) :]))
    return catalogue_trial(entry, shop.context, joint, values, shop.mean.rows)
