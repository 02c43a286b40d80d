"""Parametrised motions with exact derivatives."""

from oed.design.trajectories.fourier import FourierClass
from oed.design.trajectories.harmonic import HarmonicClass
from oed.design.trajectories.linear import LinearClass
from oed.design.trajectories.spline import SplineClass
from oed.design.trajectories.trajectory import TrajectoryClass

__all__ = ["FourierClass", "HarmonicClass", "LinearClass", "SplineClass", "TrajectoryClass"]
