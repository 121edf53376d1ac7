"""Rotors as inertia of bodies, where a body can do what they do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.model import Term, TorqueModel

Array = NDArray[np.float64]


def rotors_in_bodies(model: TorqueModel) -> TorqueModel:
    """For a format without rotors: those of joints whose axis nothing turns are thin discs on their
    links, which do the same in every motion."""
    if model.standard is None:
        return model
    within = [_does_what_its_link_does(term, model.robot) for term in model.terms]
    standard, own = model.standard.copy(), np.ones(len(model.covariance), dtype=bool)
    for k in np.flatnonzero(within):
        (j,), (inertia,) = model.terms[k].joints, model.terms[k].coefficients
        standard[j] += _disc(model.robot.axis[j], float(inertia))
        own[model.term_slice(int(k))] = False
    return replace(
        model,
        h=model.base.of(standard),
        standard=standard,
        terms=tuple(t for t, gone in zip(model.terms, within, strict=True) if not gone),
        covariance=model.covariance[np.ix_(own, own)],
    )


def _does_what_its_link_does(term: Term, robot: Robot) -> bool:
    if not term.effect.is_rotor:
        return False
    (j,) = term.joints
    return bool(robot.parent[j] < 0 and not robot.prismatic[j])


def _disc(axis: Array, inertia: float) -> Array:
    """(10,) standard parameters of a thin disc without mass about an axis through the origin."""
    tensor = 0.5 * inertia * (np.eye(3) + np.outer(axis, axis))
    return np.concatenate([np.zeros(4), tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]])
