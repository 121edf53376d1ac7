"""All figures of one diagnosis, by name: what the report and the page both show."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.diagnose.outcome.words import helped_most
from pa10d.diagnose.unknown.structure import Structure
from pa10d.figures.decimate import thinned
from pa10d.figures.errors import binned
from pa10d.figures.evidence import before_after, evidence
from pa10d.figures.held_out import HeldOut
from pa10d.figures.plotly import MODEL, Figure, axis, dots, layout, line, packed
from pa10d.figures.staircase import Stair, staircase
from pa10d.figures.structure_map import structure_map
from pa10d.figures.traces import over_frequency, over_order, over_time
from pa10d.figures.views import ViewAxis, direction, near, quantity_of

Array = NDArray[np.float64]

POINTS = 1500
OVER_TIME = "over time"
FEWEST = 50  # samples worth a plot


def diagnosis_figures(found: Diagnosis, seen: HeldOut) -> JsonObject:
    """``staircase``; per finding ``findings``: ``joint`` (from 1) that is shown, ``evidence`` (name
    -> figure, the best first) and ``before_after``; ``unexplained``: a map per entry, None where
    nobody knows what it depends on."""
    names = found.model.robot.joint_names
    return {
        "staircase": staircase(steps_of(found), names, known_floor(found)),
        "findings": [
            {
                "joint": shown_joint(found, k) + 1,
                "evidence": evidence_figures(found, seen, k),
                "before_after": before_after(
                    names, found.findings[k].rms_before, found.findings[k].rms_after,
                    known_floor(found),
                ),
            }
            for k in range(len(found.findings))
        ],
        "unexplained": [
            structure_map(s, seen) if isinstance(s, Structure) else None for s in found.unexplained
        ],
    }  # fmt: skip


def steps_of(found: Diagnosis) -> list[Stair]:
    """From the model as it was given on, errors on the same held-out data; short names for an
    axis."""
    begun = ("start", "anew")[: len(found.stages) - len(found.findings)]
    names = (*begun, *(f"step {k}" for k in range(1, len(found.findings) + 1)))
    return [Stair(name, *stage) for name, stage in zip(names, found.stages, strict=True)]


def known_floor(found: Diagnosis) -> Array | None:
    """(n,) N·m, nan where it is not known; None where it is for no joint."""
    return found.noise_floor if bool(np.any(np.isfinite(found.noise_floor))) else None


def shown_joint(found: Diagnosis, k: int) -> int:
    """0-based: the one that its sentence tells of."""
    finding = found.findings[k]
    return helped_most(finding.term, finding.rms_before, finding.rms_after)[0]


def evidence_figures(found: Diagnosis, seen: HeldOut, k: int) -> dict[str, Figure]:
    """Name -> figure, the most telling one first."""
    term, joint = found.findings[k].term, shown_joint(found, k)
    before, after = seen.seen[k], seen.seen[k + 1]
    level = float(found.noise_floor[joint])
    floor = level if np.isfinite(level) else None
    out: dict[str, Figure] = {}
    quantity, drawn = quantity_of(term), term.effect.drawn
    if quantity is not None:
        out |= _against(found, seen, k, quantity, floor)
    if drawn.over_time:
        out = {OVER_TIME: {}, **out}
    out[OVER_TIME] = over_time(before, after, joint, floor)
    if drawn.over_frequency:
        out["over frequency"] = over_frequency(before, after, joint, found.cutoff)
    if term.effect.line_order:
        orders = over_order(before, after, joint)
        out |= {} if orders is None else {"over cycles per revolution": orders}
    return out


def _against(
    found: Diagnosis, seen: HeldOut, k: int, quantity: ViewAxis, floor: float | None
) -> dict[str, Figure]:
    term, joint = found.findings[k].term, shown_joint(found, k)
    runs = seen.seen[k + 1]
    robot = found.model.robot
    own = term.joints[0] if term.joints else joint
    other = term.joints[-1] if term.joints else joint
    label = quantity.label.format(
        own=own + 1, other=other + 1, angle=robot.angle_unit(other), unit=robot.torque_unit(own)
    )  # fmt: skip
    unit = robot.torque_unit(joint)
    x = seen.counted([quantity.x(run, term, joint) for run in runs], joint)
    turn = seen.counted([direction(term, run, joint) for run in runs], joint)
    torque = [run.equation.filtered(term.torque(run.seen)[:, joint], joint) for run in runs]
    shows = seen.counted([quantity.shows(run, term, joint) for run in runs], joint)
    chosen = near(term, x) & (turn != 0) & shows
    if chosen.sum() < FEWEST:
        return {}
    x, turn = x[chosen], turn[chosen]
    towards = " (along the motion)" if term.effect.drawn.along else ""
    drawn = evidence(
        x, label, turn * seen.error(k, joint)[chosen], turn * seen.error(k + 1, joint)[chosen],
        turn * seen.change(k + 1, joint)[chosen], floor=floor, unit=unit,
    )  # fmt: skip
    if drawn["data"][2]["mode"] == "markers":  # no curve: then a mean says nothing
        del drawn["data"][1]
    drawn["layout"]["legend"]["itemsizing"] = "constant"
    drawn["layout"]["yaxis"]["title"]["text"] = f"joint {joint + 1}, {unit}{towards}"
    law = _law(x, label, turn * seen.counted(torque, joint)[chosen], f"torque, {unit}{towards}")
    return {"residual and effect": drawn, "the effect's law": law}


def _law(x: Array, label: str, torque: Array, title: str) -> Figure:
    """The whole torque of the effect, that part included which other terms had imitated."""
    chosen = thinned(len(x), POINTS)
    middle, rows = binned(x, torque, 90)
    data = [dots("samples", x[chosen], torque[chosen], MODEL)]
    if len(rows):
        data.append(line("mean", rows[:, 1], MODEL, x=packed(middle), width=3))
    return {"data": data, "layout": layout(330, xaxis=axis(label), yaxis=axis(title))}
