"""How to read the plots of a case study."""

from __future__ import annotations

from pa10d.figures.texts import Reading

CONVERGENCE = Reading(
    "Each curve is a parameter estimated from only those samples that are faster than the "
    "threshold, with two standard errors. Dotted: the band within which the inertia is the same "
    "as that of the fast samples. Dashed: the boundary that was chosen.",
    "Where the curves lie level, the linear friction model holds. A Coulomb level that rises to "
    "the left means more friction at low speed; an inertia that moves means friction with memory.",
)
FRICTION_MAP = Reading(
    "Friction torque against speed in both directions, with inertia, bias and gravity taken away. "
    "Orange: the straight line through the fast part, carried on to standstill. Dashed: the "
    "boundary.",
    "Dots that leave the line near standstill are the friction that the textbook model lacks. If "
    "they leave it at the fast end, look for nonlinear viscous friction instead.",
)
EXCITING = Reading(
    "Above, one period of the exciting trajectory. Below, each joint's speed in units of its own "
    "boundary velocity: within the grey band its samples do not count for set A.",
    "A joint that stays in the band for long is excited badly for set A: raise its limits or lower "
    "the boundary's interval with more cycles.",
)
RECONSTRUCTION = Reading(
    "Torque of a motion that no fit has seen: measured, and as both models make it. Below, what "
    "each of them misses. Both sides are low-passed alike.",
    "Spikes at reversals of the joint are friction at low speed, which neither model has a term "
    "for; between them the better model is the one whose error stays near zero.",
)
TRACKING = Reading(
    "Commanded minus measured position over whole cycles, by the same loop with the same feedback "
    "gains; the model adds its torque to the feedback.",
    "Peaks at reversals are friction. If they stay although the model is used, the model's "
    "friction at low speed is wrong or missing.",
)
BARS = Reading(
    "The same errors as one number per joint: shorter is better.",
    "A model is worth loading where its bars are clearly shorter than the PID's at the speeds that "
    "the arm works at.",
)
