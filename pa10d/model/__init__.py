"""Torque models: what an identification leaves, and what every question is asked of."""

from pa10d.model.model import Parameters, TorqueModel
from pa10d.model.notes import Delivery, ModelNotes
from pa10d.model.term import Term, as_told, in_units_of, label, spread
from pa10d.model.unknowns import Unknowns, vector_of

__all__ = [
    "Delivery",
    "ModelNotes",
    "Parameters",
    "Term",
    "TorqueModel",
    "Unknowns",
    "as_told",
    "in_units_of",
    "label",
    "spread",
    "vector_of",
]
