"""What an effect says of its part in searches, plots, loops and exports has to be possible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pa10d.control.live_model import LiveEffect
from pa10d.dynamics import Robot
from pa10d.effect_kit import draws
from pa10d.effect_kit.numbers import bare
from pa10d.effects import Effect, all_effects
from pa10d.figures.views import QUANTITIES
from pa10d.trajectory.kinds import KINDS

PROPERTIES = ("", "armature", "damping", "friction")


def played(kind: Effect, robot: Robot, rng: np.random.Generator, count: int) -> str | None:
    """Views, confounders, experiments and shape parameters that it names are there; what the loop
    is to evaluate, it can."""
    view, shapes = kind.drawn, {s.name for s in kind.shapes}
    if kind.view is not None and view.against not in {"", *QUANTITIES}:
        return f"'view' is against {view.against!r}, expected one of {', '.join(QUANTITIES)}"
    if view.near is not None and view.near[0] not in shapes:
        return f"'view' is near {view.near[0]!r}, which is no shape parameter"
    if kind.line_order and kind.line_order not in shapes:
        return f"'line_order' is {kind.line_order!r}, which is no shape parameter"
    if kind.joint_property not in PROPERTIES:
        return f"'joint_property' is {kind.joint_property!r}, expected one of {PROPERTIES[1:]}"
    unknown = [other for other in kind.confounders if other not in all_effects()]
    if unknown:
        return f"'confounders' names {unknown[0]!r}, and there is no such effect"
    if kind.experiment_kind not in KINDS:
        return f"'experiment_kind' is {kind.experiment_kind!r}, expected one of {', '.join(KINDS)}"
    return _live(kind, robot, rng, count) if kind.live else None


def _live(kind: Effect, robot: Robot, rng: np.random.Generator, count: int) -> str | None:
    if kind.scope != "joint" or kind.sensing:
        return "'live' is for effects of one joint that are no sensor's"
    for _ in range(count):
        path = draws.path(rng, robot, 10)
        term = draws.term(rng, kind, draws.context(robot, path))
        shape = {name: np.array([value]) for name, value in term.shape.items()}
        part = LiveEffect(kind.id, term.joints, term.coefficients[None], shape)
        found = np.zeros_like(path.q)
        try:
            part.add(found, path.dq, path.ddq)
        except AttributeError as error:
            return f"'live' columns may use dq and ddq only ({error})"
        model = bare(robot, term)
        given = (path.q, path.dq, path.ddq)
        own = model.torque(*given) - replace(model, terms=model.terms[:-1]).torque(*given)
        if not np.allclose(found, own, rtol=1e-9, atol=1e-9):
            return "the loop's torque is not the model's: 'live' columns may use dq and ddq only"
    return None
