"""A weight at the flange of a virtual arm: what somebody does by hand to a real one.

It is as far from what is stated as its errors say, drawn once for each weight: on a real arm nobody
knows it better either.
"""

from __future__ import annotations

import zlib

import numpy as np

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.identify.scale import Body
from pa10d.profile import Profile, Simulation

OWN_PLANT = str(Simulation().plant)


def with_weight(profile: Profile, body: Body) -> Profile:
    """The virtual arm with this weight bolted on."""
    simulation = profile.simulation
    if simulation is None or simulation.plant != OWN_PLANT:
        raise UserError(
            f"{profile.path}: simulation.plant: a weight can be hung on {OWN_PLANT} only; hang it "
            "on yours by its own options"
        )
    options = dict(simulation.options)
    options["effects"] = [*options.get("effects", ()), _really(body, simulation.seed)]
    changed = simulation.model_copy(update={"options": options})
    return profile.model_copy(update={"simulation": changed})


def _really(body: Body, seed: int) -> JsonObject:
    rng = np.random.default_rng([seed, zlib.crc32(body.text.encode())])
    mass, x, y, z = np.array([body.mass, *body.com]) + rng.normal(size=4) * body.errors
    return {"effect": "payload", "mass": max(mass, 1e-3), "cx": x, "cy": y, "cz": z}
