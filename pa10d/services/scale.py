"""Torque gains by known weights, from runs of the store: figures, words, and what to hang next."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.common.words import joint_words, listed
from pa10d.dynamics import Robot
from pa10d.identify.scale import (
    Body,
    JointGain,
    Load,
    Prospect,
    TorqueGains,
    prospects,
    torque_gains,
)
from pa10d.identify.scale.prediction import ASIDE, WANTED, best, heavier, limited_by_noise
from pa10d.measurement.recording import Recording
from pa10d.services.torque_scale import JointScale, TorqueScale, WeightProspect
from pa10d.store import RunStore


def torque_scale(
    robot: Robot,
    store: RunStore,
    empty: Sequence[str],
    loads: Sequence[tuple[Body, Sequence[str]]],
    at_hand: Sequence[Body] = (),
) -> TorqueScale:
    """Gains from runs without and with weights, and what each weight at hand would bring."""
    given = [Load(_read(store, runs, robot), body) for body, runs in loads]
    found = torque_gains(robot, _read(store, empty, robot), given)
    seen = prospects(robot, found, at_hand)
    chosen = best(found, seen)
    masses = [body.mass for body, _ in loads]
    heavy = heavier(robot, found, masses) if chosen is None else None
    return TorqueScale(
        joints=tuple(_joint(robot, j, joint) for j, joint in enumerate(found.joints)),
        prospects=tuple(_prospect(one, one is chosen) for one in seen),
        next_mass=heavy,
        advice=_advice(robot, found, chosen, seen, heavy, masses),
    )


def _read(store: RunStore, names: Sequence[str], robot: Robot) -> list[Recording]:
    runs = [store.recording(store.find(name)) for name in names]
    for name, run in zip(names, runs, strict=True):
        if run.joints != robot.n:
            raise UserError(f"run {name!r}: {run.joints} joints, expected {robot.n}")
    return runs


def _joint(robot: Robot, j: int, joint: JointGain) -> JointScale:
    told = joint.told
    return JointScale(
        joint=j + 1,
        name=robot.joint_names[j],
        gain=_finite(joint.gain) if told else None,
        std_error=_finite(joint.std_error) if told else None,
        of_noise=_finite(joint.of_noise) if told else None,
        of_weight=_finite(joint.of_body) if told else None,
        between=joint.between,
        friction_with_load=_finite(joint.rubs) if joint.between else None,
        disagree=bool(joint.disagree),
        asked=_finite(joint.asked),
        why=joint.why or None,
        map=f"--map 'tau{j + 1}[{1 / joint.gain:.4g}]=tau{j + 1}'" if told else "",
    )


def _prospect(one: Prospect, chosen: bool) -> WeightProspect:
    return WeightProspect(
        weight=one.body.text,
        mass=one.body.mass,
        std_error=tuple(_finite(v) for v in one.std_error),
        worst=_finite(one.worst),
        too_much=None if one.too_much is None else one.too_much + 1,
        aside=tuple(j + 1 for j in one.aside),
        axis=one.axis or None,
        next=chosen,
    )


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _advice(
    robot: Robot,
    found: TorqueGains,
    chosen: Prospect | None,
    seen: Sequence[Prospect],
    heavy: float | None,
    masses: Sequence[float],
) -> str:
    return " ".join([_next(found, chosen, seen, heavy, masses), *_caveats(robot, found, seen)])


def _next(
    found: TorqueGains,
    chosen: Prospect | None,
    seen: Sequence[Prospect],
    heavy: float | None,
    masses: Sequence[float],
) -> str:
    error = found.std_error
    told = np.isfinite(error)
    if chosen is not None:
        return (
            f"Hang {chosen.body.words} next: {_joints(np.isfinite(chosen.std_error))} would be "
            f"known to {chosen.worst:.1%} or better."
        )
    body = np.array([joint.of_body for joint in found.joints])
    noise = np.array([joint.of_noise for joint in found.joints])
    if heavy is not None:
        limited = limited_by_noise(found)
        after = np.max(noise[limited]) * max(masses) / heavy
        return (
            f"Hang {heavy:g} kg next: noise would leave {_joints(limited)} at {after:.1%} or less."
        )
    if told.any() and error[told].max() <= WANTED:
        return f"Every gain that can be told is known to {WANTED:.0%}."
    poor = told & (body > noise) & (error > WANTED)
    if poor.any():
        return (
            f"What limits {_joints(poor)} is how well the weight is known: weigh it, and "
            "measure where its centre is, more closely."
        )
    split = np.array([joint.spread > WANTED for joint in found.joints])
    if split.any() and not limited_by_noise(found).any():
        return f"No weight tells more of {_joints(split)} while recordings disagree."
    if seen and not told.any():
        over = [one for one in seen if one.too_much is not None]
        return (
            f"No weight at hand fits: {over[0].body.mass:g} kg is more than joint "
            f"{(over[0].too_much or 0) + 1} may carry in this motion."
            if over else "No weight at hand would tell any joint's gain."
        )  # fmt: skip
    return "No heavier weight fits within the torque limits: record longer, or move more slowly."


def _caveats(robot: Robot, found: TorqueGains, seen: Sequence[Prospect]) -> list[str]:
    said = []
    rubbing = np.array([joint.between is not None for joint in found.joints])
    if rubbing.any():
        said.append(
            f"Friction of {_joints(rubbing)} goes with the load: where it acts more while the "
            "motor drives than while the load drives, the gain lies lower, down to the bound; no "
            "mass can tell these apart (the motor's back-EMF constant can: its volts per rad/s are "
            "its N·m per ampere)."
        )
    split = np.array([joint.disagree for joint in found.joints])
    if split.any():
        said.append(
            f"Recordings disagree about {_joints(split)} by more than their errors, which were "
            "widened: what is called torque is not in proportion to it, or the weight was not what "
            "was stated."
        )
    for one in seen:
        if one.aside:
            named = listed([str(j + 1) for j in one.aside])
            said.append(
                f"Hung {ASIDE:g} m to the side (along {one.axis}), {one.body.mass:g} kg would tell "
                f"joint {named}, too."
            )
            break
    return said


def _joints(which: Any) -> str:
    return joint_words(np.flatnonzero(which))
