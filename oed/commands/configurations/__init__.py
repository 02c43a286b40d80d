"""What every command can be told: frozen configurations, and nothing that takes time to load.

`oed --help` and shell completion read these classes alone. The names of models and effects stand
here as text; a test holds that they are those of the library.
"""

from oed.commands.configurations.chains import Calibrate, Demo
from oed.commands.configurations.command import (
    Command,
    DataCommand,
    DataSetCommand,
    ModelName,
    Prior,
)
from oed.commands.configurations.designing import CLEARANCE, MOST_CLEARANCE, MOST_POINTS, Design
from oed.commands.configurations.estimating import Check, Diagnose, Feasible, Identify
from oed.commands.configurations.importing import ImportLog
from oed.commands.configurations.loads import Gains, LoadCommand, Payload
from oed.commands.configurations.models import CrossCheck, Export

__all__ = [
    "CLEARANCE",
    "MOST_CLEARANCE",
    "MOST_POINTS",
    "Calibrate",
    "Check",
    "Command",
    "CrossCheck",
    "DataCommand",
    "DataSetCommand",
    "Demo",
    "Design",
    "Diagnose",
    "Export",
    "Feasible",
    "Gains",
    "Identify",
    "ImportLog",
    "LoadCommand",
    "ModelName",
    "Payload",
    "Prior",
]
