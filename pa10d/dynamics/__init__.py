"""Rigid bodies: kinematic tree, torque regressor, base parameters, physical feasibility.

Arrays in, arrays out. Nothing here knows of files, processes or devices.
"""

from pa10d.dynamics.base import BaseParameters, base_parameters
from pa10d.dynamics.derivatives import sensitivities
from pa10d.dynamics.geometry import Freedom, freedoms
from pa10d.dynamics.inverse import inverse_dynamics
from pa10d.dynamics.regressor import regressor
from pa10d.dynamics.robot import Robot, robot_from_profile, robot_from_urdf
from pa10d.dynamics.typical import typical_inertia

__all__ = [
    "BaseParameters",
    "Freedom",
    "Robot",
    "base_parameters",
    "freedoms",
    "inverse_dynamics",
    "regressor",
    "robot_from_profile",
    "robot_from_urdf",
    "sensitivities",
    "typical_inertia",
]
