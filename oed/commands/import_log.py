"""`oed import`: a data set of log files."""

from __future__ import annotations

from oed.commands.configurations import ImportLog
from oed.commands.telling import say, speak
from oed.experiment.importing.import_log import ImportChoices, propose_import, write_import
from oed.experiment.importing.stated import stated_numbers, stated_words


def import_into(config: ImportLog) -> tuple[str, ...]:
    """Read, conclude, check, write; returns what was concluded."""
    choices = ImportChoices(
        robot=config.robot,
        joints=config.joints,
        columns=stated_words("--columns", config.columns),
        units=stated_words("--units", config.units),
        sign=config.sign,
        zero=config.zero,
        ticks_per_turn=config.ticks_per_turn,
        rate=config.rate,
        fixed=stated_numbers("--fixed", config.fixed),
        torque=config.torque,
        current_to_torque=config.current_to_torque,
        gravity=config.gravity,
        roles=config.roles,
    )
    found = propose_import(config.logs, choices, config.out)
    write_import(found, config.out, reference=config.reference)
    return found.notes


def run(config: ImportLog) -> int:
    """Import, and say what was concluded."""
    speak(quiet=config.quiet)
    for note in import_into(config):
        say(f"  {note}")
    print(f"wrote {config.out}; read dataset.toml there and correct what is wrong")
    return 0
