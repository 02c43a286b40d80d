"""Optimal experiment design and dynamic calibration of robot arms.

The packages stand in the order in which data flow, and import only from their left:

    robot → dynamics → design → experiment → estimation → diagnosis → report

robot        What the machine is: kinematics, inertial parameters, gravity, limits.
dynamics     What torque a motion needs: rigid body, friction and every further effect.
design       Which motion to ask for: trajectory classes, criteria, exact limits, optimisers.
experiment   Run it or read it: recordings, data sets, filters, control, simulation.
estimation   What the data say: parameters with honest uncertainty, and validation.
diagnosis    What the model still lacks: lack of fit, candidate effects, selection.
report       Files to hand on: provenance, tables, figures, pages. It draws and never computes.

commands     What a user runs: `oed`, one thin file a command.

A notebook needs `import oed` alone: it offers the names of `oed.__all__`, each loaded when it is
used. `oed.errors` holds the outcomes that all of them report as errors.
Units are SI throughout; the symbols are in NOTATION.md.
"""

import lazy_loader

__version__ = "0.1.0"
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
