"""Errors of sensors and motors of a size that shows."""

from __future__ import annotations

from backends.virtual.datasets.figures import Draw, Figures, Rng, any_joint, carrying, sign
from pa10d.common.jsonable import JsonObject


def _offset(rng: Rng, f: Figures) -> JsonObject:
    j = any_joint(rng, f)
    return {"joint": j + 1, "offset": sign(rng) * rng.uniform(0.2, 0.6) * f.book.coulomb[j]}


def _encoder(rng: Rng, f: Figures) -> JsonObject:
    j = any_joint(rng, f, 0.02 * f.slope)
    return {"joint": j + 1, "offset": sign(rng) * rng.uniform(0.015, 0.05)}


def _gain(rng: Rng, f: Figures) -> JsonObject:
    return {"joint": any_joint(rng, f) + 1, "gain": 1.0 + sign(rng) * rng.uniform(0.06, 0.2)}


def _saturation(rng: Rng, f: Figures) -> JsonObject:
    j = any_joint(rng, f, 0.1 * carrying(f))
    return {"joint": j + 1, "cubic": rng.uniform(0.05, 0.11) / f.peak[j] ** 2}


def _delay(rng: Rng, f: Figures) -> JsonObject:
    return {"joint": any_joint(rng, f) + 1, "Td": rng.uniform(0.01, 0.025)}


SENSES: dict[str, Draw] = {
    "torque_offset": _offset,
    "encoder_offset": _encoder,
    "torque_gain": _gain,
    "torque_saturation": _saturation,
    "torque_delay": _delay,
}
