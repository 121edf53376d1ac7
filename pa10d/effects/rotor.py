"""What of a joint's load and inertia sits on the motor's side of its gear.

Of a joint that turns about a fixed axis a rigid model cannot tell the rotor from the link: one base
parameter holds both, and the model's load is the torque at the rotor. Effects of what lies between
the two look at the link, and take the rotor's inertia for a shape parameter.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.effects.base import ShapeParameter
from pa10d.effects.context import Context

Array = NDArray[np.float64]

ROTOR = ShapeParameter("rotor", "kg·m²", 0.0, 1e3, optional=True, step=lambda s: 0.25 * s["rotor"])
LIGHTEST = 0.02  # of the inertia that a joint moves: the least that a link is taken to have


def link_load(context: Context, joint: int, rotor: float) -> Array:
    """(N,) N·m that the gear passes on to the link."""
    return np.asanyarray(context.load[:, joint] - rotor * context.ddq[:, joint])


def quiet_link_load(context: Context, joint: int, rotor: float) -> Array:
    """The same for an effect of the load's size, which is not to be that of an encoder's noise."""
    ddq = context.quiet_ddq if context.drowned[joint] else context.ddq
    return np.asanyarray(context.quiet_load[:, joint] - rotor * ddq[:, joint])


def link_inertia(context: Context, joint: int, rotor: float) -> Array:
    """(N,) kg·m²: M_jj(q) without what sits on the motor's side."""
    seen = context.inertia_seen(joint)
    return np.maximum(seen - rotor, LIGHTEST * float(seen.max()))


def typical_link(context: Context, joint: int, rotor: float) -> float:
    """The same over the joint's range, kg·m²."""
    typical = float(context.typical_inertia[joint])
    return max(typical - rotor, LIGHTEST * typical)


def rotor_starts(context: Context, joint: int, shares: Sequence[float]) -> list[dict[str, float]]:
    """Where a search for the rotor's part of the least inertia begins; not at all where the model
    knows its rotor."""
    if joint not in context.rotor_in_load:
        return [{}]
    least = float(context.inertia_seen(joint).min())
    return [{"rotor": share * least} for share in shares]
