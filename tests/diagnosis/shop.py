"""A diagnosis up to its search, for tests of the parts of the search."""

from collections import OrderedDict

from oed.diagnosis.settings import DiagnosisSettings
from oed.diagnosis.tables.workshop import Workshop
from oed.diagnosis.terms.trials import catalogue_trial
from oed.diagnosis_new.noise.baseline import Baseline, find_baseline
from oed.dynamics.effects.catalogue import CATALOGUE
from oed.dynamics.torque_model import TorqueModel
from oed.experiment.dataset import DataSet
from oed.experiment.preparation.prepare import prepare
from oed.experiment.preparation.prepared import Prepared

KEPT = 12  # data sets whose baseline is known: many tests begin with the same

known: OrderedDict[tuple, tuple[DataSet, tuple[Prepared, ...], Baseline]] = OrderedDict()


def shop_of(dataset, *, held=True, **settings):
    """Where terms for a data set are tried, with its validation recordings if `held`."""
    chosen = DiagnosisSettings(**settings)
    prepared, baseline = baseline_of(dataset, chosen)
    own, validation = (with_role(prepared, role) for role in ("estimation", "validation"))
    return Workshop(baseline, own, validation if held else (), chosen)


def baseline_of(dataset, settings):
    """The recordings brought to their band and the model to start with."""
    key = (id(dataset),)
    if key not in known:
        prepared = prepare(dataset.recordings)
        model = TorqueModel.standard(dataset.robot)
        # With the data set itself, whose number no other may get.
        known[key] = dataset, prepared, find_baseline(model, with_role(prepared, "estimation"))
    known.move_to_end(key)
    if len(known) > KEPT:
        known.popitem(last=False)
    _, prepared, baseline = known[key]
    return prepared, baseline


def with_role(prepared, role):
    return tuple(p for p in prepared if p.role == role)


def trial_of(shop, name, joint, values=()):
    """An effect of the catalogue with these shapes, those left out at their defaults."""
    entry = CATALOGUE[name]
    values = (*values, *(shape.default for shape in entry.shapes[len(values) :]))
    return catalogue_trial(entry, shop.context, joint, values, shop.mean.rows)
