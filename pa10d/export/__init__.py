"""A model for other programs: a URDF with identified inertias, a Python module of its own."""

from pa10d.export.python_module import python_module
from pa10d.export.urdf import urdf_with_inertia

__all__ = ["python_module", "urdf_with_inertia"]
