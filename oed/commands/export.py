"""`oed export`: a found model as something that runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from oed.commands.configurations import Export
from oed.commands.telling import say, speak
from oed.export.kinds.sample_files import write_samples
from oed.export.model import Model
from oed.export.model_file import load_model, model_file_at
from oed.export.registry import Exported, Target, find_exporter
from oed.report.json_file import write_json
from oed.report.provenance import Provenance
from oed.report.study_files import EXPORT


def run(config: Export) -> int:
    """Write the model in every form that was asked for, and say what each has and lacks."""
    speak(quiet=config.quiet)
    exporters = {name: find_exporter(name) for name in config.to}
    path = model_file_at(config.model)
    model = load_model(path)
    with EXPORT.in_folder(config.out, [path]) as results, results.replaced() as new:
        target = Target(new, results.folder, 1 / config.rate)
        done = {name: write(model, target) for name, write in exporters.items()}
        if config.samples:
            done["samples"] = write_samples(model, target, config.samples, config.seed)
        write_record(path.name, model, done, Provenance.collect(config, seed=None), new)
    for name, exported in done.items():
        _tell(name, exported, config.out)
    return 0


def write_record(
    name: str, model: Model, done: Mapping[str, Exported], provenance: Provenance, folder: Path
) -> None:
    """Leave export.json: what was made of the model of that name."""
    record = {"format": 1, "model": name, "origin": model.origin, "exports": done}
    of = {"versions": provenance.versions, "commit": provenance.commit, "date": provenance.date}
    write_json(folder / "export.json", {**record, **of})


def _tell(name: str, exported: Exported, out: Path) -> None:
    print(f"{name}: {', '.join(str(out / file) for file in exported.files)}")
    say(f"  {exported.use}")
    for note in exported.notes:
        print(f"  note: {note}")
    reasons = {left.reason: [] for left in exported.left_out}
    for left in exported.left_out:
        if left.name not in reasons[left.reason]:
            reasons[left.reason].append(left.name)
    for reason, names in reasons.items():
        print(f"  left out: {', '.join(names)}: {reason}")
