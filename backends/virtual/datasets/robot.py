"""The robot that a data set is about: its profile and the limits of its motions."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from backends.virtual.datasets.motions import Reach
from backends.virtual.plant.assemble import arm_model
from pa10d.profile import Profile, load_profile


def open_robot(profile: str | os.PathLike[str] | Profile) -> Profile:
    """A profile by name or file; a URDF alone is a whole robot too."""
    if isinstance(profile, Profile):
        return profile
    path = Path(profile)
    if path.suffix == ".urdf":
        return Profile(path=path.resolve(), name=path.stem, urdf=path.resolve())
    return load_profile(profile)


def reach_of(profile: Profile) -> Reach:
    """Position and velocity limits; joints that turn for ever get ±π, missing speeds 2 rad/s."""
    model = arm_model(profile)
    limits = profile.limits
    if limits.position is not None:
        lower, upper = np.array(limits.position, float).T
    else:
        lower, upper = np.full((2, model.nv), np.nan)
        for i in range(model.nv):
            joint = model.joints[i + 1]
            if joint.nq == 1:
                lower[i] = model.lowerPositionLimit[joint.idx_q]
                upper[i] = model.upperPositionLimit[joint.idx_q]
    speed = np.asarray(model.velocityLimit if limits.velocity is None else limits.velocity, float)
    known = np.isfinite(lower) & np.isfinite(upper) & (upper - lower < 30) & (upper > lower)
    usable = np.isfinite(speed) & (speed > 0) & (speed < 50)
    return Reach(
        np.where(known, lower, -np.pi), np.where(known, upper, np.pi), np.where(usable, speed, 2.0)
    )
