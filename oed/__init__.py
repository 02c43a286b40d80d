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

`oed.errors` holds the outcomes that all of them report as errors.
Units are SI throughout; the symbols are in NOTATION.md.
"""

__version__ = "0.1.0"
