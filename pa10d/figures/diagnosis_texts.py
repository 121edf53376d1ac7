"""How to read the plots of a diagnosis."""

from __future__ import annotations

from pa10d.figures.texts import Reading

EVIDENCE = Reading(
    "Each blue dot is a moment of a run that the fit has not seen: measured torque minus what the "
    "model without this effect says. Orange is what the effect explains of it (what other terms of "
    "the model had already imitated is not in it). The list above offers other looks: the effect's "
    "whole torque, and the course over time.",
    "If the orange runs through the middle of the blue cloud and what is left with it is flat, the "
    "effect is real. If only part of the blue follows the orange, something else is at work beside "
    "it.",
    "Green is the width of the noise, within which what is left should lie.",
)
COURSE = Reading(
    "Above, in grey, the torque that the model without this effect leaves over, in a stretch of a "
    "run that the fit has not seen; in orange what the effect explains of it. Below, on the same "
    "scale, what is left with it. In the gaps the joint stands still, where friction can be "
    "anything.",
    "If the orange covers the grey and the lower line shows no shape, the effect is real. If only "
    "part of the grey follows the orange, something else is at work beside it.",
    "Green is the width of the noise, within which the lower line should stay.",
)
BEFORE_AFTER = Reading(
    "For every joint the error that is left on data not fitted, without the effect (grey) and with "
    "it (blue).",
    "The joints concerned must fall, and no other may rise.",
    "Beside them the noise (green), which no model can go below: where blue reaches green there is "
    "nothing left to find.",
)
STAIRCASE = Reading(
    "From left to right, every step adds one effect; each line is a joint, judged on the same "
    "held-out data. The tip of the pointer shows N·m.",
    "A line that goes down belongs to a joint that the effect concerns; one that goes up speaks "
    "against it.",
    "Errors are divided by the noise: 1 (dashed) is as good as it gets, and a line that ends high "
    "above it has something left: see what no effect explains.",
)
MAP = Reading(
    "Colour is the torque that is left over on this joint, at each combination of the two "
    "variables: orange too much is measured, blue too little, pale nothing. Left, a map drawn from "
    "the fitted data alone; right, what the held-out data show there. That both look alike is why "
    "this is no chance.",
    "Look at which place of the machine the coloured region belongs to: a cable that tightens "
    "there, a cover that rubs, a neighbour that bends it. A region of one sign in both directions "
    "of motion acts like a spring or weight, one that changes its sign with them like friction.",
)
CURVE = Reading(
    "Blue dots: torque left over on this joint in held-out data, and its mean as a line. Orange: "
    "the curve drawn from the fitted data alone. That both agree is why this is no chance.",
    "Look for what in the machine follows this variable, and do a run in which it moves alone.",
)
