"""Torque models: what an identification leaves, and what every question is asked of."""

from pa10d.model.model import Parameters, Term, TorqueModel, as_told, in_units_of, label, spread

__all__ = ["Parameters", "Term", "TorqueModel", "as_told", "in_units_of", "label", "spread"]
