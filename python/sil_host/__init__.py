"""A simulated quadrotor, its attitude controllers, and what a flight log says of both.

SI units; a name ends in its unit. Body axes are forward, right, down, world axes north, east, down. What can't be used
is refused with a :class:`SilError`, whose text says why.
"""

from ._native import (
    Core,
    Diagnosis,
    Flight,
    Log,
    Model,
    Plant,
    Sensors,
    SilError,
    Study,
    compare,
    diagnose,
    fly,
    identify,
    margins,
    synth,
    tuning,
)

__all__ = [
    "Core",
    "Diagnosis",
    "Flight",
    "Log",
    "Model",
    "Plant",
    "Sensors",
    "SilError",
    "Study",
    "compare",
    "diagnose",
    "fly",
    "identify",
    "margins",
    "synth",
    "tuning",
]
